// A GCRA (ITU-T I.371 annex A) whose clock stops while a transaction of the class is on the line: the time
// that the transaction took is added to the instant at which the bucket was empty.
#include "takt/bus/transaction_gate.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"

namespace takt::bus {

TransactionGate::TransactionGate(std::uint32_t burst, Duration interval)
    : interval_(interval), capacity_(interval) {
    TAKT_ASSERT(burst >= 1 && interval >= Duration::zero());
    if (interval > Duration::zero())
        capacity_ = interval *
                    std::min<std::int64_t>(burst, std::max<std::int64_t>(1, Duration::max() / 4 / interval));
}

Instant TransactionGate::next_admission(Instant t) const {
    const Instant filled = after(empty_at_, interval_);
    if (running_ > 0) return filled <= stopped_at_ ? t : kNever;
    return std::max(t, filled);
}

void TransactionGate::started(Instant t) {
    const bool admitted = admits(t);
    resumed(t);
    empty_at_ = admitted ? empty_at_ + interval_ : stopped_at_;
}

void TransactionGate::resumed(Instant t) {
    if (running_++ > 0) return;
    stopped_at_ = t;
    empty_at_ = std::max(empty_at_, t - capacity_);
}

void TransactionGate::ended(Instant t) {
    TAKT_ASSERT(running_ > 0);
    if (--running_ == 0 && t > stopped_at_) empty_at_ += t - stopped_at_;
}

}  // namespace takt::bus
