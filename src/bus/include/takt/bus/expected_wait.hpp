// The time-out that the measured response times of a device allow.
#pragma once

#include <algorithm>
#include <chrono>

#include "takt/base/time.hpp"

namespace takt::bus {

/// Four times the slowest response so far plus 50 ms, at most `longest`.
[[nodiscard]] inline Duration expected_wait(Duration slowest, Duration longest) {
    constexpr int kFactor = 4;
    constexpr Duration kLeast = std::chrono::milliseconds(50);
    return std::min(longest, kFactor * slowest + kLeast);
}

}  // namespace takt::bus
