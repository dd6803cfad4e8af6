#include "takt/bus/release.hpp"

#include <bit>

#include "takt/base/assert.hpp"

namespace takt::bus {

std::uint64_t PeriodicRelease::serve(Instant t) {
    TAKT_ASSERT(t >= next_);
    if (period_ == Duration::zero()) {
        next_ = t;
        return 0;
    }
    const auto passed = (t - next_) / period_;
    next_ += (passed + 1) * period_;
    return static_cast<std::uint64_t>(passed);
}

bool PeriodMeter::started(Instant t) {
    const Duration interval = t - last_;
    last_ = t;
    if (!running_) {
        running_ = true;
        return false;
    }
    recent_ = real_.count() == 0 ? interval : recent_ + (interval - recent_) / 8;
    real_.record(interval);
    if (period_ == Duration::zero()) return false;
    const Duration tolerated = period_ + period_ / 20;
    long_ones_ = static_cast<std::uint8_t>(long_ones_ << 1 | (interval > tolerated ? 1 : 0));
    const bool before = overrun_;
    if (std::popcount(long_ones_) >= 3 && recent_ > tolerated) overrun_ = true;
    if (long_ones_ == 0) overrun_ = false;
    return overrun_ != before;
}

}  // namespace takt::bus
