// Wall-clock times as text: ISO 8601, RFC 3339.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace takt {

inline constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

/// Nanoseconds since 1970-01-01T00:00:00Z, as all times of this header.
[[nodiscard]] inline std::int64_t nanoseconds_of(std::chrono::system_clock::time_point time) {
    return std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
}

enum class Fraction : std::uint8_t { none, milliseconds };

/// "2026-11-24T08:00:00.250Z"; a shorter part of a second is cut off.
[[nodiscard]] std::string utc_time_text(std::int64_t time_ns, Fraction fraction = Fraction::milliseconds);
/// "2026-11-24T10:00:00.250+02:00": the same instant in a zone with that offset from UTC.
[[nodiscard]] std::string offset_time_text(std::int64_t time_ns, std::chrono::seconds offset);

/// A time as it is written.
struct WrittenTime {
    std::chrono::year_month_day day;
    std::chrono::nanoseconds since_midnight{};
    std::optional<std::chrono::minutes> offset;  ///< from UTC; nothing: the text states none
    bool is_complete = true;                     ///< RFC 3339: with seconds, and `T` between day and clock

    /// Of its offset; without one as in UTC.
    [[nodiscard]] std::int64_t utc_ns() const;
};

/// "2026-11-24", "2026-11-24T10:00", with seconds, with a fraction of up to nine digits, with "Z" or
/// "+02:00". A blank may stand for `T`.
/// @returns nothing if the text has another form, or names no time of the years 1700 to 2250
[[nodiscard]] std::optional<WrittenTime> read_time(std::string_view text);

/// The complete form with an offset alone, of the years 1970 to 2199.
[[nodiscard]] std::optional<std::int64_t> read_utc_time(std::string_view text);

}  // namespace takt
