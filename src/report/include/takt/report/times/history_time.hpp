// Times of a history as text.
#pragma once

#include <cstdint>
#include <ctime>
#include <optional>
#include <string>
#include <string_view>

#include "takt/base/iso_time.hpp"

namespace takt::report {

/// Parses a time. Accepted: "now"; "-2h", "-1.5d": before now, in ms, s, m, h, d or w;
/// "2026-11-24", "2026-11-24T10:00", with seconds, with a fraction, with "Z" or "+02:00". Without "Z" or an
/// offset the time is local.
/// @returns ns since 1970 UTC; nothing if the text has another form or names no existing time
[[nodiscard]] std::optional<std::int64_t> parse_history_time(std::string_view text, std::int64_t now_ns);

/// "2026-11-24T10:00:00.250+02:00", in the zone of this computer.
[[nodiscard]] std::string local_time_text(std::int64_t time_ns);
/// Date and clock in that zone.
[[nodiscard]] std::tm local_fields(std::int64_t time_ns);
/// "10:00:00" on the day of `reference_ns`, else "2026-11-24 10:00:00"; local.
[[nodiscard]] std::string short_time_text(std::int64_t time_ns, std::int64_t reference_ns);

}  // namespace takt::report
