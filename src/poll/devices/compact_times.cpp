#include "devices/compact_times.hpp"

#include <algorithm>
#include <utility>

#include "takt/base/histogram_definitions.hpp"
#include "takt/base/latency_statistics_definitions.hpp"

namespace takt::poll {

template <std::size_t buckets>
void CountRange<buckets>::resize(std::size_t before, std::size_t size) {
    const auto move_to = [&](Words& words) {
        Words moved(size);
        std::ranges::copy(words, moved.begin() + static_cast<std::ptrdiff_t>(before));
        words = std::move(moved);
    };
    move_to(low_);
    if (high_) move_to(*high_);
}

template <std::size_t buckets>
void CountRange<buckets>::include(std::size_t bucket) {
    const std::size_t step = bucket - bucket % kStep;
    if (low_.empty()) first_ = step;
    if (step < first_) {
        resize(first_ - step, first_ - step + low_.size());
        first_ = step;
    } else if (const std::size_t size = step - first_ + kStep; size > low_.size()) {
        resize(0, size);
    }
}

template <std::size_t buckets>
void CountRange<buckets>::add(std::size_t bucket, std::uint64_t times) {
    if (bucket < first_ || bucket - first_ >= low_.size()) include(bucket);
    auto& low = low_[bucket - first_];
    const std::uint64_t sum = low + (times & UINT32_MAX);
    low = static_cast<std::uint32_t>(sum);
    const auto carry = static_cast<std::uint32_t>((times >> 32) + (sum >> 32));
    if (carry == 0) return;
    if (!high_) high_ = HeapOptional(Words(low_.size()));
    (*high_)[bucket - first_] += carry;
}

HistogramSnapshot snapshot_of(const HeapOptional<CompactLatencyStatistics>& optional) {
    if (!optional) return {};
    const auto& times = *optional;
    HistogramSnapshot result{.count = times.count(),
                             .p50 = times.percentile(50),
                             .p99 = times.percentile(99),
                             .longest = times.max(),
                             .buckets = {}};
    const auto add = [](std::uint32_t count, std::uint64_t more) {
        return static_cast<std::uint32_t>(std::min<std::uint64_t>(count + more, UINT32_MAX));
    };
    for (std::size_t i = 0; i < CompactHistogram::kBuckets; ++i) {
        const auto bucket = times.histogram().bucket(i);
        if (bucket.count == 0) continue;
        const auto upper = std::chrono::ceil<std::chrono::microseconds>(std::min(bucket.upper, times.max()));
        if (result.buckets.size() < result.buckets.capacity()) result.buckets.push_back({});
        auto& last = result.buckets.back();
        last.upper_us = static_cast<std::uint32_t>(std::min<std::int64_t>(upper.count(), UINT32_MAX));
        last.count = add(last.count, bucket.count);
    }
    return result;
}

}  // namespace takt::poll

namespace takt {

template class BasicHistogram<3, 26, 1000, poll::CountRange>;
template class BasicLatencyStatistics<poll::CompactHistogram>;

}  // namespace takt
