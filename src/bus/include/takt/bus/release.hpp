// The release times of polled requests, and their real periods.
#pragma once

#include <algorithm>
#include <cstdint>

#include "takt/base/time.hpp"
#include "takt/bus/counters.hpp"

namespace takt::bus {

/// A polled request is overdue when it has waited for this many of its deadlines. It is then promoted above
/// the normal priorities, so that a line that is slower than planned starves no request. If the plan holds
/// its periods, only faults make a request late; the factor is larger then, and the others keep the
/// priorities that the guarantees assume.
/// @param utilization  of the plan; above 1 it cannot hold its periods
constexpr int overdue_factor(double utilization) {
    return utilization > 1 ? 1 : 4;
}

/// Releases on a grid: origin + n * period. Releases that pass while one is waiting are skipped. So there is
/// no burst after a delay, and the phase does not drift.
class PeriodicRelease {
public:
    /// @param period  zero: always released
    explicit PeriodicRelease(Duration period) : period_(period) {}

    /// Sets the origin of the grid to `t`.
    void restart(Instant t) { next_ = origin_ = last_ = t; }

    /// Sets the origin. The next release is the first instant of the grid at or after `t`.
    void follow(Instant origin, Instant t);

    /// Adds a release at `t`, off the grid.
    void release_at(Instant t) { next_ = std::min(next_, t); }

    /// The release that waits, or the next one.
    [[nodiscard]] Instant next() const { return next_; }

    /// The waiting release is served at `t` >= next(). @returns how many further releases have passed
    std::uint64_t serve(Instant t);

    /// The instant of the grid to which the release served last belongs.
    [[nodiscard]] Instant last() const { return last_; }

private:
    [[nodiscard]] std::int64_t intervals(Instant t) const;

    Duration period_;
    Instant origin_;
    Instant next_;
    Instant last_;
};

/// The longest distance of reads that keep the period.
[[nodiscard]] constexpr Duration tolerated_period(Duration period) {
    return period + period / 20;
}

/// Compares the distance of polled reads with the configured period, and measures how often they are
/// answered.
class PeriodMeter {
public:
    /// @param period  zero: no period is too long
    explicit PeriodMeter(Duration period) : period_(period) {}

    /// A polled read starts. @returns whether overrun() changed
    bool started(Instant t);

    /// No read has started since the last one. @returns whether an overrun began: the current interval is
    /// longer than four periods, beyond the tolerance
    bool waiting(Instant t);
    /// When waiting() would begin an overrun; kNever: it has begun, or no read is expected.
    [[nodiscard]] Instant overrun_due() const;

    /// Polling is interrupted on purpose: the time until the next start is no overrun.
    void interrupt() { running_ = false; }

    /// The mean distance of about the last eight starts, as overrun() judges it.
    [[nodiscard]] Duration pace() const { return pace_; }

    /// A read got a normal response. @param start  of its transaction
    void answered(Instant start);

    /// The device is switched off: the time until its next answer does not count as a period.
    void pause();

    /// The times between answered reads, from start to start. Reads without a normal response, outages and
    /// lost links make them longer.
    [[nodiscard]] const TimeStatistics& real() const { return real_; }
    /// The mean of about the last eight of them.
    [[nodiscard]] Duration recent() const { return recent_; }
    /// An overrun begins when at least three of the last eight periods and the moving mean are more than 5 %
    /// too long, or while one of them lasts for longer than four. It ends when the period was kept for ten
    /// periods and for 10 s: all that time at most one of the last eight periods was too long, and the latest
    /// is not. So a line near its limit does not change the state with every round.
    [[nodiscard]] bool overrun() const { return overrun_; }
    /// Whether the period is exceeded now: within an overrun, the one that is awaited is too long; or the
    /// mean, and two of the last eight or the latest, are.
    [[nodiscard]] bool is_late() const;

private:
    Duration period_;
    bool running_ = false;
    bool overrun_ = false;
    bool awaited_ = false;        // the overrun began while a read was awaited, which has not started yet
    std::uint8_t long_ones_ = 0;  // the last eight periods, one bit each: too long
    bool has_answer_ = false;
    Instant kept_since_;  // of an overrun
    Instant last_;        // start
    Duration pace_{};
    Instant last_answered_;
    Duration recent_{};
    TimeStatistics real_;
};

}  // namespace takt::bus
