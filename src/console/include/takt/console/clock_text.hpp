// The local time of an instant, as JSON, traffic logs and lines of values show it.
#pragma once

#include <string>

#include "takt/base/time.hpp"

namespace takt::console {

/// "2026-11-21T19:50:04.906+02:00": ISO 8601, local time with its offset from UTC.
[[nodiscard]] std::string iso_time(Instant t);
/// "21-11-2026 19:50:04.906", local time. The traffic log has it from its source (docs/specification.md,
/// section 5).
[[nodiscard]] std::string time_stamp(Instant t);
/// "19:50:04.906", local time.
[[nodiscard]] std::string time_of_day(Instant t);

}  // namespace takt::console
