// When a polled request is due, and how long its real period is.
#pragma once

#include <algorithm>
#include <cstdint>

#include "takt/base/time.hpp"
#include "takt/bus/counters.hpp"

namespace takt::bus {

/// How many of its deadlines polling waits before it goes first whatever its priority, so that a line that is
/// slower than planned starves nobody. Where the plan holds its periods, what waits longer than its deadline
/// waits because of faults: the others keep their priorities, as the guarantees assume.
/// @param utilization  of the plan; above 1 it cannot hold its periods
constexpr int patience(double utilization) {
    return utilization > 1 ? 1 : 4;
}

/// Releases on the grid of a period. Those that pass while one is waiting are skipped: no burst, no drift.
class PeriodicRelease {
public:
    /// @param period  zero: always released
    explicit PeriodicRelease(Duration period) : period_(period) {}

    /// The grid begins anew at `t`.
    void restart(Instant t) { next_ = origin_ = last_ = t; }

    /// The grid is origin + n * period. What comes next is its first instant at or after `t`.
    void follow(Instant origin, Instant t);

    /// Releases once more at `t`, between the instants of the grid.
    void release_at(Instant t) { next_ = std::min(next_, t); }

    /// The release that is waiting or comes next.
    [[nodiscard]] Instant next() const { return next_; }

    /// The waiting release is served at `t` >= next(). @returns how many others passed meanwhile
    std::uint64_t serve(Instant t);

    /// The instant of the grid that the release served last belongs to.
    [[nodiscard]] Instant last() const { return last_; }

private:
    [[nodiscard]] std::int64_t intervals(Instant t) const;

    Duration period_;
    Instant origin_;
    Instant next_;
    Instant last_;
};

/// Compares the real period with the set one.
class PeriodMeter {
public:
    /// @param period  zero: nothing can be too long
    explicit PeriodMeter(Duration period) : period_(period) {}

    /// A polled read starts. @returns whether overrun() changed
    bool started(Instant t);

    /// The polling is interrupted on purpose: the time until the next start is no period.
    void interrupt() { running_ = false; }

    [[nodiscard]] const TimeStatistics& real() const { return real_; }
    [[nodiscard]] Duration recent() const { return recent_; }
    /// At least three of the last eight periods, and their mean, were more than 5 % too long; until at most
    /// one of eight is, and the latest is not.
    [[nodiscard]] bool overrun() const { return overrun_; }

private:
    Duration period_;
    bool running_ = false;
    bool overrun_ = false;
    std::uint8_t long_ones_ = 0;  // of the last eight periods, one bit each
    Instant last_;
    Duration recent_{};
    TimeStatistics real_;
};

}  // namespace takt::bus
