// The local time of an instant, as everything that the program prints or writes shows it.
#pragma once

#include <string>

#include "takt/base/time.hpp"

namespace takt::console {

/// "2026-11-21T19:50:04.906+02:00": ISO 8601, local time with its offset from UTC.
[[nodiscard]] std::string iso_time(Instant t);

}  // namespace takt::console
