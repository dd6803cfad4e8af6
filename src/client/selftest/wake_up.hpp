// How late timers are.
#pragma once

#include "takt/base/latency_statistics.hpp"
#include "takt/line/loop.hpp"

namespace takt::client {

/// A timer that is set once in `pace`, and how late each of its callbacks came. Instants that have passed
/// meanwhile are left out.
class WakeUp {
public:
    /// @param loop, statistics  outlive it
    WakeUp(line::Loop& loop, Duration pace, LatencyStatistics& statistics);

private:
    void expire(Instant t);

    Duration pace_;
    LatencyStatistics& statistics_;
    Instant due_;
    line::Timer timer_;
};

}  // namespace takt::client
