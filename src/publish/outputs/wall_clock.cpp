#include "takt/publish/wall_clock.hpp"

#include <chrono>

#include "takt/line/loop.hpp"

namespace takt::publish {

std::int64_t system_wall_ns(Instant t) {
    const auto since = line::wall_clock(t).time_since_epoch();
    return std::chrono::duration_cast<std::chrono::nanoseconds>(since).count();
}

}  // namespace takt::publish
