// How late timers are.
#pragma once

#include "takt/line/loop.hpp"
#include "takt/timing/latency_statistics.hpp"

namespace takt::selftest {

/// A timer that is set once in `pace`, and how late each of its callbacks came. Instants that have passed
/// meanwhile are left out.
class WakeUp {
public:
    /// @param loop, statistics  outlive it
    WakeUp(line::Loop& loop, Duration pace, timing::LatencyStatistics& statistics);

private:
    void expire(Instant t);

    Duration pace_;
    timing::LatencyStatistics& statistics_;
    Instant due_;
    line::Timer timer_;
};

}  // namespace takt::selftest
