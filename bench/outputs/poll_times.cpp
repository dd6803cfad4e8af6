#include "poll_times.hpp"

#include <algorithm>
#include <chrono>
#include <utility>
#include <variant>

namespace takt::bench {
namespace {

using namespace std::chrono_literals;

/// `t` - `start` without whole periods: -period/2 to period/2.
Duration phase(Instant t, Instant start, Duration period) {
    return (t - start + period / 2) % period - period / 2;
}

/// The moment from which a line is polled in whole periods: that of its earliest request. Requests that are
/// far from most others were sent after a failure, and do not count.
Instant grid_of(const std::vector<Instant>& sent, Duration period) {
    Instant start = sent.front();
    const auto is_far = [&](Instant t) { return std::chrono::abs(phase(t, start, period)) > period / 4; };
    if (2 * static_cast<std::size_t>(std::ranges::count_if(sent, is_far)) > sent.size()) start += period / 2;
    std::vector<Duration> phases;
    for (const Instant t : sent) phases.push_back(phase(t, start, period));
    std::ranges::sort(phases);
    const Duration usual = phases[phases.size() / 2];
    return start + *std::ranges::lower_bound(phases, usual - period / 20);
}

}  // namespace

PollTimes::PollTimes(std::unique_ptr<host::Session> session, std::size_t lines, Duration period)
    : session_(std::move(session)), period_(period), sent_(lines) {
    thread_ = std::thread([this] { run(); });
}

PollTimes::~PollTimes() {
    ending_ = true;
    thread_.join();
}

void PollTimes::run() {
    while (!ending_) {
        read();
        (void)session_->wait(100ms);
    }
}

void PollTimes::read() {
    const std::lock_guard lock(mutex_);
    while (const auto record = session_->next_traffic()) {
        if (record->direction != wire::Direction::sent || record->source.index >= sent_.size()) continue;
        auto& sent = sent_[record->source.index];
        // Only a repetition comes so early: it follows the response time-out.
        if (!sent.empty() && record->t - sent.back() < period_ * 9 / 20)
            ++repetitions_;
        else
            sent.push_back(record->t);
    }
    while (const auto event = session_->next_event()) {
        const auto* const link = std::get_if<host::LinkChanged>(&event->body);
        if (link != nullptr && !link->up) ++lost_;
    }
    lost_ += session_->missed_traffic() - std::exchange(missed_, session_->missed_traffic());
}

PollTimes::Window PollTimes::window(Instant from, Instant to) const {
    const std::lock_guard lock(mutex_);
    Window window;
    for (const auto& times : sent_) {
        if (times.empty()) continue;
        const Instant grid = grid_of(times, period_);
        for (std::size_t i = 1; i < times.size(); ++i) {
            if (times[i] < from || times[i] >= to) continue;
            window.lateness.push_back(std::max(Duration{}, phase(times[i], grid, period_)));
            window.missed += static_cast<std::size_t>((times[i] - times[i - 1] - period_ / 2) / period_);
        }
    }
    std::ranges::sort(window.lateness);
    return window;
}

}  // namespace takt::bench
