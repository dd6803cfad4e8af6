// Admission by two limits: a window of undecided attempts and a token bucket. An attempt leaves the window
// when it succeeds, fails, or exceeds undecided_limit. Tickets ascend, so both maps are ordered first come,
// first served.
#include "takt/line/connect_gate.hpp"

#include <algorithm>

namespace takt::line {

ConnectGate::ConnectGate(Loop& loop, const ConnectLimits& limits)
    : limits_(limits),
      bucket_(TokenBucket::create(limits.burst, limits.interval).value()),
      timer_(loop, [this](Instant t) { let_in(t); }) {}

ConnectGate::Pass ConnectGate::ask(std::function<void()> admitted) {
    const std::uint64_t ticket = ++last_ticket_;
    waiting_.emplace(ticket, std::move(admitted));
    arm(now());
    return {this, ticket};
}

void ConnectGate::leave(std::uint64_t ticket) {
    const bool was_under_way = under_way_.erase(ticket) > 0;
    if (!was_under_way) waiting_.erase(ticket);
    arm(now());
}

void ConnectGate::let_in(Instant t) {
    while (!under_way_.empty() && t >= after(under_way_.begin()->second, limits_.undecided_limit))
        under_way_.erase(under_way_.begin());
    while (!waiting_.empty() && under_way_.size() < limits_.most && bucket_.admit(t)) {
        auto first = waiting_.extract(waiting_.begin());
        under_way_.emplace(first.key(), t);
        first.mapped()();
    }
    arm(t);
}

void ConnectGate::arm(Instant t) {
    if (waiting_.empty()) return timer_.set(kNever);
    const bool below_limit = under_way_.size() < limits_.most;
    timer_.set(below_limit ? bucket_.next_admission(t)
                           : after(under_way_.begin()->second, limits_.undecided_limit));
}

}  // namespace takt::line
