// The loop of a simulated wire: from one wake-up to the next.
#pragma once

#include <algorithm>

#include "takt/base/assert.hpp"
#include "takt/base/time.hpp"

namespace takt::sim {

/// Calls `step` at each wake-up until `t`, with `now` set to it; then sets `now` to `t`. An engine that asks
/// for the same moment again and again is a programmer's mistake.
template <class NextWakeup, class Step>
void step_until(Instant t, Instant& now, NextWakeup next_wakeup, Step step) {
    constexpr int kMaxStepsAtOneMoment = 10'000;
    int steps = 0;
    for (Instant next = next_wakeup(); next <= t; next = next_wakeup()) {
        steps = next > now ? 0 : steps + 1;
        TAKT_ASSERT(steps < kMaxStepsAtOneMoment);
        now = std::max(now, next);
        step();
    }
    now = std::max(now, t);
}

}  // namespace takt::sim
