// The end of transmission is computed from the bit rate. Then the transmitter is polled each half character
// until it is empty. A port that cannot report this gets a fixed delay for the adapter instead.
#include "serial/direction_switch.hpp"

#include <algorithm>

namespace takt::line {

void DirectionSwitch::sent(Instant t, std::size_t bytes) {
    const bool sending = next_check_ != kNever;
    end_ = (sending ? std::max(end_, t) : t) + wire::transmission_time(format_, bytes);
    next_check_ = end_;
}

bool DirectionSwitch::release(Instant t, std::optional<bool> empty) {
    if (t < next_check_) return false;
    const bool done = empty.value_or(t >= end_ + kAdapterDelay) || t >= end_ + kLongestWait;
    if (done)
        next_check_ = kNever;
    else if (empty)
        next_check_ = t + wire::transmission_time(format_, 1) / 2;
    else
        next_check_ = end_ + kAdapterDelay;
    return done;
}

}  // namespace takt::line
