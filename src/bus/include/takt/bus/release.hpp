// When a polled request is due, and how long its real period is.
#pragma once

#include <cstdint>

#include "takt/base/time.hpp"
#include "takt/bus/counters.hpp"

namespace takt::bus {

/// Releases on the grid of a period. Those that pass while one is waiting are skipped: no burst, no drift.
class PeriodicRelease {
public:
    /// @param period  zero: always released
    explicit PeriodicRelease(Duration period) : period_(period) {}

    /// The grid begins anew at `t`.
    void restart(Instant t) { next_ = t; }

    /// The release that is waiting or comes next.
    [[nodiscard]] Instant next() const { return next_; }

    /// The waiting release is served at `t` >= next(). @returns how many others passed meanwhile
    std::uint64_t serve(Instant t);

private:
    Duration period_;
    Instant next_;
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
    /// At least three of the last eight periods, and their mean, were more than 5 % too long; until none of
    /// eight was.
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
