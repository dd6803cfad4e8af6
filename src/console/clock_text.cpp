#include "takt/console/clock_text.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "takt/line/loop.hpp"

namespace takt::console {
namespace {

std::chrono::sys_time<std::chrono::milliseconds> wall_milliseconds(Instant t) {
    return std::chrono::floor<std::chrono::milliseconds>(line::wall_clock(t));
}

std::tm local(std::chrono::sys_time<std::chrono::milliseconds> time) {
    return fmt::localtime(std::chrono::system_clock::to_time_t(time));
}

}  // namespace

std::string iso_time(Instant t) {
    const auto wall = wall_milliseconds(t);
    const std::string offset = fmt::format("{:%z}", local(wall));  // "+0200"
    return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}{}:{}", local(wall), wall.time_since_epoch().count() % 1000,
                       offset.substr(0, 3), offset.substr(3));
}

}  // namespace takt::console
