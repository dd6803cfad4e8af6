// Parses scalars of a project file. YAML's own rules are not used: they read 010 as 8 and `no` as a bool.
#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>

#include "takt/base/time.hpp"

namespace takt::model {

/// Why a text cannot be parsed.
enum class ScalarError : std::uint8_t {
    malformed,     ///< no number, duration, … at all
    fraction,      ///< a number, but not a whole one
    leading_zero,  ///< 010: 10 or, as YAML 1.1 has it, 8?
    no_unit,       ///< a duration other than 0 without its unit
    too_large,     ///< beyond 64 bits, or beyond what a double holds
};

template <class T>
using Scalar = std::expected<T, ScalarError>;

/// A whole number of up to 64 bits and a sign: holds every int64 and every uint64.
struct Integer {
    std::uint64_t magnitude = 0;
    bool negative = false;

    /// The number itself where it is within int64.
    [[nodiscard]] std::optional<std::int64_t> as_int64() const;
};

/// Decimal (`-12`) or hexadecimal (`0x1F`), without leading zeros.
[[nodiscard]] Scalar<Integer> parse_integer(std::string_view text);

/// Decimal with point and exponent (`-1.5e3`); neither infinite nor not-a-number.
[[nodiscard]] Scalar<double> parse_number(std::string_view text);

/// A decimal number of ns, us, ms, s, min, h or d (`100ms`, `1.5 s`); 0 needs no unit. Exact to the
/// nanosecond, not negative.
[[nodiscard]] Scalar<Duration> parse_duration(std::string_view text);

/// true or false, in lower or upper case or capitalised, as in YAML 1.2.
[[nodiscard]] std::optional<bool> parse_bool(std::string_view text);

/// The duration in the greatest unit that gives an integer, except minutes and one day: "0ms",
/// "100ms", "1s", "24h", "7d".
[[nodiscard]] std::string to_text(Duration duration);

/// The shortest text that reads back as the same number: "10", "0.1".
[[nodiscard]] std::string to_text(double number);

/// `-0,1` as `-0.1`; empty for anything but a number with a decimal comma.
[[nodiscard]] std::string with_point(std::string_view text);

/// `1,000` as `1000`; empty for anything but digits in groups of three.
[[nodiscard]] std::string without_thousands(std::string_view text);

}  // namespace takt::model
