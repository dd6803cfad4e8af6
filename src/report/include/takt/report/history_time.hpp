// Times of a history as text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace takt::report {

inline constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

/// Parses a time. Accepted: "now"; "-2h", "-1.5d": before now, in ms, s, m, h, d or w;
/// "2026-11-24", "2026-11-24T10:00", with seconds, with a fraction, with "Z" or "+02:00". Without "Z" or an
/// offset the time is local.
/// @returns ns since 1970 UTC; nothing if the text has another form or names no existing time
[[nodiscard]] std::optional<std::int64_t> parse_history_time(std::string_view text, std::int64_t now_ns);

/// "2026-11-24T08:00:00.250Z"
[[nodiscard]] std::string utc_time_text(std::int64_t time_ns);
/// "2026-11-24T10:00:00.250+02:00"
[[nodiscard]] std::string local_time_text(std::int64_t time_ns);
/// "10:00:00" on the day of `reference_ns`, else "2026-11-24 10:00:00"; local.
[[nodiscard]] std::string short_time_text(std::int64_t time_ns, std::int64_t reference_ns);

}  // namespace takt::report
