// The wall clock of an output.
#pragma once

#include <cstdint>
#include <functional>

#include "takt/base/time.hpp"

namespace takt::publish {

/// The wall-clock time of an instant, in nanoseconds since 1970 UTC. It may jump between two calls.
using WallClock = std::function<std::int64_t(Instant t)>;

/// The clock of the operating system. Any thread.
[[nodiscard]] std::int64_t system_wall_ns(Instant t);

}  // namespace takt::publish
