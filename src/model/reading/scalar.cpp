#include "takt/model/scalar.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "takt/base/ascii.hpp"

namespace takt::model {
namespace {

constexpr std::uint64_t kInt64Max = std::numeric_limits<std::int64_t>::max();

bool has_leading_zero(std::string_view digits) {
    return digits.size() > 1 && digits[0] == '0' && is_digit(digits[1]);
}

/// The reason why a text is no integer, for example another kind of number.
ScalarError not_an_integer(std::string_view text) {
    const auto number = parse_number(text);
    if (number || number.error() == ScalarError::too_large) return ScalarError::fraction;
    return ScalarError::malformed;
}

struct Unit {
    std::string_view name;
    std::int64_t nanoseconds;
};
// The longer name first where one is the end of the other.
constexpr std::array kUnits{
    Unit{"min", 60'000'000'000},
    Unit{"ns", 1},
    Unit{"us", 1'000},
    Unit{"µs", 1'000},
    Unit{"ms", 1'000'000},
    Unit{"s", 1'000'000'000},
    Unit{"h", 3'600'000'000'000},
    Unit{"d", 86'400'000'000'000},
};

/// `whole.fraction` units in nanoseconds, exactly.
Scalar<Duration> multiple(std::string_view whole, std::string_view fraction, std::int64_t unit) {
    std::int64_t count = 0;
    const auto read = std::from_chars(whole.data(), whole.data() + whole.size(), count);
    std::int64_t total = 0;
    if (read.ec != std::errc{} || __builtin_mul_overflow(count, unit, &total))
        return std::unexpected(ScalarError::too_large);
    std::int64_t weight = unit;
    for (const char digit : fraction) {
        if (digit != '0' && (weight == 0 || weight % 10 != 0)) return std::unexpected(ScalarError::fraction);
        weight /= 10;
        if (__builtin_add_overflow(total, (digit - '0') * weight, &total))
            return std::unexpected(ScalarError::too_large);
    }
    return Duration(total);
}

}  // namespace

std::optional<std::int64_t> Integer::as_int64() const {
    if (!negative) {
        if (magnitude > kInt64Max) return std::nullopt;
        return static_cast<std::int64_t>(magnitude);
    }
    if (magnitude > kInt64Max + 1) return std::nullopt;
    return static_cast<std::int64_t>(0 - magnitude);
}

Scalar<Integer> parse_integer(std::string_view text) {
    auto digits = text;
    const bool negative = digits.starts_with('-');
    if (negative) digits.remove_prefix(1);
    const bool hexadecimal = digits.starts_with("0x") || digits.starts_with("0X");
    if (hexadecimal)
        digits.remove_prefix(2);
    else if (!all_digits(digits))
        return std::unexpected(not_an_integer(text));
    else if (has_leading_zero(digits))
        return std::unexpected(ScalarError::leading_zero);
    std::uint64_t magnitude = 0;
    const auto read =
        std::from_chars(digits.data(), digits.data() + digits.size(), magnitude, hexadecimal ? 16 : 10);
    if (read.ec == std::errc::invalid_argument || read.ptr != digits.data() + digits.size())
        return std::unexpected(ScalarError::malformed);
    if (read.ec != std::errc{}) return std::unexpected(ScalarError::too_large);
    return Integer{magnitude, negative && magnitude != 0};
}

Scalar<double> parse_number(std::string_view text) {
    const auto digits = text.starts_with('-') ? text.substr(1) : text;
    if (digits.empty() || !is_digit(digits[0])) return std::unexpected(ScalarError::malformed);
    if (has_leading_zero(digits)) return std::unexpected(ScalarError::leading_zero);
    double number = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
    if (read.ec == std::errc::invalid_argument || read.ptr != text.data() + text.size())
        return std::unexpected(ScalarError::malformed);
    if (read.ec != std::errc{} || !std::isfinite(number)) return std::unexpected(ScalarError::too_large);
    return number;
}

Scalar<Duration> parse_duration(std::string_view text) {
    const auto number_end = std::min(text.find_first_not_of("0123456789."), text.size());
    const auto number = text.substr(0, number_end);
    auto unit_name = text.substr(number_end);
    unit_name.remove_prefix(std::min(unit_name.find_first_not_of(' '), unit_name.size()));
    const auto point = std::min(number.find('.'), number.size());
    const auto whole = number.substr(0, point);
    const auto fraction = number.substr(std::min(point + 1, number.size()));
    if (!all_digits(whole) || (point < number.size() && !all_digits(fraction)))
        return std::unexpected(ScalarError::malformed);
    if (has_leading_zero(whole)) return std::unexpected(ScalarError::leading_zero);
    if (unit_name.empty()) {
        if (number == "0") return Duration::zero();
        return std::unexpected(ScalarError::no_unit);
    }
    const auto* const unit = std::ranges::find(kUnits, unit_name, &Unit::name);
    if (unit == kUnits.end()) return std::unexpected(ScalarError::malformed);
    return multiple(whole, fraction, unit->nanoseconds);
}

std::optional<bool> parse_bool(std::string_view text) {
    if (text == "true" || text == "True" || text == "TRUE") return true;
    if (text == "false" || text == "False" || text == "FALSE") return false;
    return std::nullopt;
}

std::string to_text(double number) {
    std::array<char, 32> buffer{};
    const auto written = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number);
    return {buffer.data(), written.ptr};
}

std::string to_text(Duration duration) {
    constexpr std::array kShown{Unit{"d", 86'400'000'000'000},
                                Unit{"h", 3'600'000'000'000},
                                Unit{"s", 1'000'000'000},
                                Unit{"ms", 1'000'000},
                                Unit{"us", 1'000},
                                Unit{"ns", 1}};
    const std::int64_t count = duration.count();
    if (count == 0) return "0ms";
    for (const auto& [name, nanoseconds] : kShown)
        if (count % nanoseconds == 0 && (name != "d" || count > nanoseconds))
            return std::to_string(count / nanoseconds).append(name);
    std::unreachable();
}

std::string with_point(std::string_view text) {
    const auto comma = text.find(',');
    if (comma == std::string_view::npos) return {};
    const auto whole = text.substr(text.starts_with('-') ? 1 : 0, comma - (text.starts_with('-') ? 1 : 0));
    if (!all_digits(whole) || !all_digits(text.substr(comma + 1))) return {};
    return std::string(text.substr(0, comma)) + '.' + std::string(text.substr(comma + 1));
}

std::string without_thousands(std::string_view text) {
    constexpr std::size_t kGroup = 3;
    const auto comma = text.find(',');
    if (comma > kGroup || text.starts_with('0') || !all_digits(text.substr(0, comma))) return {};
    std::string meant(text.substr(0, comma));
    for (auto rest = text.substr(comma); !rest.empty(); rest.remove_prefix(kGroup + 1)) {
        const auto group = rest.substr(1, kGroup);
        if (rest[0] != ',' || group.size() < kGroup || !all_digits(group)) return {};
        meant += group;
    }
    return meant;
}

}  // namespace takt::model
