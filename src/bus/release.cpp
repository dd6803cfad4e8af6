// The release grid: instants origin + n * period. A release is served at the latest instant of the grid that
// has passed; earlier ones count as skipped. So a delay of any length keeps the phase, and no
// burst follows it.
#include "takt/bus/release.hpp"

#include <bit>
#include <utility>

#include "takt/base/assert.hpp"

namespace takt::bus {

// Whole periods since the origin, rounded down.
std::int64_t PeriodicRelease::intervals(Instant t) const {
    const std::int64_t whole = (t - origin_) / period_;
    return origin_ + whole * period_ > t ? whole - 1 : whole;
}

void PeriodicRelease::follow(Instant origin, Instant t) {
    origin_ = origin;
    next_ = std::max(origin, t);
    if (period_ == Duration::zero() || t <= origin) return;
    const Instant before = origin_ + intervals(t) * period_;
    next_ = before == t ? t : before + period_;
}

std::uint64_t PeriodicRelease::serve(Instant t) {
    TAKT_ASSERT(t >= next_);
    if (period_ == Duration::zero()) {
        next_ = last_ = t;
        return 0;
    }
    const std::int64_t now = intervals(t);
    const std::int64_t passed = now - intervals(next_);
    last_ = origin_ + now * period_;
    next_ = last_ + period_;
    return static_cast<std::uint64_t>(passed);
}

namespace {

constexpr int kLongestInterval = 4;  // periods
constexpr int kKeptPeriods = 10;
constexpr Duration kKeptTime = std::chrono::seconds(10);

}  // namespace

Instant PeriodMeter::overrun_due() const {
    if (!running_ || overrun_ || period_ == Duration::zero()) return kNever;
    return after(after(last_, kLongestInterval * tolerated_period(period_)), Duration(1));
}

bool PeriodMeter::waiting(Instant t) {
    if (t < overrun_due()) return false;
    overrun_ = awaited_ = true;
    kept_since_ = t;
    pace_ = std::max(pace_, t - last_);
    return true;
}

bool PeriodMeter::started(Instant t) {
    const Duration interval = t - last_;
    last_ = t;
    awaited_ = false;
    if (!running_) {
        running_ = true;
        kept_since_ = t;
        return false;
    }
    pace_ = pace_ == Duration::zero() ? interval : pace_ + (interval - pace_) / 8;
    if (period_ == Duration::zero()) return false;
    const Duration longest = tolerated_period(period_);
    long_ones_ = static_cast<std::uint8_t>(long_ones_ << 1 | (interval > longest ? 1 : 0));
    const bool before = overrun_;
    const int long_ones = std::popcount(long_ones_);
    if (long_ones >= 3 && pace_ > longest) overrun_ = true;
    if (long_ones > 1) kept_since_ = t;
    // The mean restarts with the current interval: past overruns must not begin a new one.
    if (before && interval <= longest && t - kept_since_ >= std::max(kKeptTime, kKeptPeriods * period_)) {
        overrun_ = false;
        pace_ = interval;
    }
    return overrun_ != before;
}

bool PeriodMeter::is_late() const {
    const bool long_ones = std::popcount(long_ones_) > 1 || (long_ones_ & 1) != 0;
    return overrun_ && (awaited_ || (long_ones && pace_ > tolerated_period(period_)));
}

void PeriodMeter::answered(Instant start) {
    if (std::exchange(has_answer_, true)) {
        const Duration interval = start - last_answered_;
        recent_ += real_.count() == 0 ? interval : (interval - recent_) / 8;
        real_.record(interval);
    }
    last_answered_ = start;
}

void PeriodMeter::pause() {
    interrupt();
    has_answer_ = false;
}

}  // namespace takt::bus
