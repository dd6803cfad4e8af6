#include "wall_time.hpp"

#include <array>
#include <cstdio>
#include <ctime>

namespace takt::web {

std::string utc_text(Instant t) {
    const auto ms = WallTime().ms(t);
    const std::time_t seconds = ms / 1000;
    std::tm parts{};
    ::gmtime_r(&seconds, &parts);
    std::array<char, 24> text{};
    std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts);
    std::array<char, 8> fraction{};
    std::snprintf(fraction.data(), fraction.size(), ".%03dZ", static_cast<int>(ms % 1000));
    return std::string(text.data()) + fraction.data();
}

}  // namespace takt::web
