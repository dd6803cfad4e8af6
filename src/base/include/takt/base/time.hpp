// Time as the engines see it: given by the caller, monotonic, never read from a clock.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

namespace takt {

using Duration = std::chrono::nanoseconds;

/// The engines' clock: only a name for its time points. The shell maps std::chrono::steady_clock onto it, the
/// simulation counts it by hand. Wall-clock time exists at the edges of the program only.
struct EngineClock {
    using rep = std::int64_t;
    using period = std::nano;
    using duration = Duration;
    using time_point = std::chrono::time_point<EngineClock, Duration>;
    static constexpr bool is_steady = true;
};

/// A moment in nanoseconds since an arbitrary start. Instant::max() stands for "never".
using Instant = EngineClock::time_point;

inline constexpr Instant kNever = Instant::max();

/// `start + length`, or kNever where that would overflow.
constexpr Instant after(Instant start, Duration length) {
    if (length > Duration::zero() && start > kNever - length) return kNever;
    return start + length;
}

}  // namespace takt
