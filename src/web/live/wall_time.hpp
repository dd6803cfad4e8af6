// Instants as browsers read them.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "takt/base/iso_time.hpp"
#include "takt/base/time.hpp"
#include "takt/line/loop.hpp"

namespace takt::web {

/// The difference between the wall clock and the engines' clock at one moment, so that all instants of one
/// message are converted alike.
class WallTime {
public:
    WallTime() : offset_(std::chrono::duration_cast<Duration>(line::wall_clock({}).time_since_epoch())) {}

    /// Milliseconds since 1970.
    [[nodiscard]] std::int64_t ms(Instant t) const {
        return std::chrono::floor<std::chrono::milliseconds>(t.time_since_epoch() + offset_).count();
    }

    /// The same with microseconds.
    [[nodiscard]] double precise_ms(Instant t) const {
        const auto us = std::chrono::floor<std::chrono::microseconds>(t.time_since_epoch() + offset_);
        return static_cast<double>(us.count()) / 1000;
    }
    [[nodiscard]] std::int64_t ns(Instant t) const { return (t.time_since_epoch() + offset_).count(); }

private:
    Duration offset_;
};

/// "2026-11-25T12:00:00.123Z"
[[nodiscard]] inline std::string utc_text(Instant t) {
    return utc_time_text(WallTime().ns(t));
}

}  // namespace takt::web
