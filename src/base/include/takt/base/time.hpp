// Time of the engines: given by the caller, monotonic, never read from a clock.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace takt {

using Duration = std::chrono::nanoseconds;

/// The engines' clock, only a tag for time points. The shell maps std::chrono::steady_clock onto it; the
/// simulation advances it by hand. Wall-clock time exists only at the edges of the program.
struct EngineClock {
    using rep = std::int64_t;
    using period = std::nano;
    using duration = Duration;
    using time_point = std::chrono::time_point<EngineClock, Duration>;
    static constexpr bool is_steady = true;
};

/// An instant in nanoseconds since an arbitrary start. Instant::max() means "never".
using Instant = EngineClock::time_point;

inline constexpr Instant kNever = Instant::max();

/// `start + length`, or kNever on overflow.
constexpr Instant after(Instant start, Duration length) {
    if (length > Duration::zero() && start > kNever - length) return kNever;
    return start + length;
}

}  // namespace takt
