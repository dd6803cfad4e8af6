#include "takt/publish/sample_queue.hpp"

#include <algorithm>
#include <utility>

namespace takt::publish {
namespace {

constexpr std::size_t kShort = 1000;  // entries

}  // namespace

bool SampleQueue::push(QueuedSamples samples) {
    const std::lock_guard lock(mutex_);
    samples.queue_full = bytes_ + samples.payload.size() > limit_;
    if (samples.queue_full) samples.payload.clear();
    return append(std::move(samples));
}

bool SampleQueue::push_loss(std::uint64_t samples, std::int64_t first_wall_ns, std::int64_t last_wall_ns) {
    const std::lock_guard lock(mutex_);
    return append({.payload = {},
                   .samples = samples,
                   .first_wall_ns = first_wall_ns,
                   .last_wall_ns = last_wall_ns,
                   .last_monotonic_ns = 0});
}

// Losses that follow each other are one, so that the queue stays bounded while nothing is taken from it. In a
// short queue each cause has its own.
bool SampleQueue::append(QueuedSamples samples) {
    const bool was_empty = waiting_.empty();
    pushed_.samples += samples.samples;
    if (samples.payload.empty()) pushed_.lost += samples.samples;
    bytes_ += samples.payload.size();
    const auto continues = [&](const QueuedSamples& last) {
        const bool same_cause = last.queue_full == samples.queue_full;
        return last.payload.empty() && (same_cause || waiting_.size() > kShort);
    };
    if (samples.payload.empty() && !was_empty && continues(waiting_.back())) {
        auto& loss = waiting_.back();
        loss.samples += samples.samples;
        loss.first_wall_ns = std::min(loss.first_wall_ns, samples.first_wall_ns);
        loss.last_wall_ns = std::max(loss.last_wall_ns, samples.last_wall_ns);
    } else {
        waiting_.push_back(std::move(samples));
    }
    return was_empty;
}

std::optional<QueuedSamples> SampleQueue::take() {
    const std::lock_guard lock(mutex_);
    if (waiting_.empty()) return std::nullopt;
    auto samples = std::move(waiting_.front());
    waiting_.pop_front();
    bytes_ -= samples.payload.size();
    return samples;
}

std::size_t SampleQueue::bytes() const {
    const std::lock_guard lock(mutex_);
    return bytes_;
}

SampleQueue::Pushed SampleQueue::pushed() const {
    const std::lock_guard lock(mutex_);
    return pushed_;
}

}  // namespace takt::publish
