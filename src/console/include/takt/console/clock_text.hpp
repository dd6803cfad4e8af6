// The local time of an instant, as logs and lines of values show it.
#pragma once

#include <string>

#include "takt/base/time.hpp"

namespace takt::console {

/// "21-11-2026 19:50:04.906", local time.
[[nodiscard]] std::string time_stamp(Instant t);
/// "19:50:04.906", local time.
[[nodiscard]] std::string time_of_day(Instant t);

}  // namespace takt::console
