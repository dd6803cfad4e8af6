// The states of the outputs of a running project, for its faces.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <vector>

#include "takt/line/loop.hpp"
#include "takt/publish/output_status.hpp"

namespace takt::console {

/// As publish::Outputs::status(). Empty: the project has no outputs.
using OutputStates = std::function<std::vector<publish::OutputStatus>()>;

/// Nanoseconds since 1970 UTC.
[[nodiscard]] inline std::int64_t wall_ns(Instant t) {
    const auto since = line::wall_clock(t).time_since_epoch();
    return std::chrono::duration_cast<std::chrono::nanoseconds>(since).count();
}

}  // namespace takt::console
