#include "takt/console/clock_text.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <string_view>

#include "takt/line/loop.hpp"

namespace takt::console {

std::string time_of_day(Instant t) {
    constexpr std::size_t kDate = std::string_view("21-11-2026 ").size();
    return time_stamp(t).substr(kDate);
}

std::string time_stamp(Instant t) {
    const auto wall = line::wall_clock(t);
    const auto ms = std::chrono::floor<std::chrono::milliseconds>(wall);
    return fmt::format("{:%d-%m-%Y %H:%M:%S}.{:03}", fmt::localtime(std::chrono::system_clock::to_time_t(ms)),
                       ms.time_since_epoch().count() % 1000);
}

}  // namespace takt::console
