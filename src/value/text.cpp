#include "takt/value/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <string>

#include "takt/base/utf8.hpp"
#include "takt/value/codec.hpp"

namespace takt::value {
namespace {

template <class Number>
Result<Number> parse_floating(std::string_view text) {
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error == std::errc::result_out_of_range) return fail(Code::overflow, text);
    if (error != std::errc{} || end != text.data() + text.size()) return fail(Code::syntax, text);
    return number;
}

/// Decimal or 0x…, with an optional minus sign.
Result<Value> parse_integer(std::string_view text) {
    std::string_view digits = text;
    const bool negative = digits.starts_with('-');
    if (negative) digits.remove_prefix(1);
    const bool hex = digits.starts_with("0x") || digits.starts_with("0X");
    if (hex) digits.remove_prefix(2);
    if (!hex && digits.size() > 1 && digits.front() == '0') return fail(Code::syntax, text);
    std::uint64_t magnitude = 0;
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), magnitude, hex ? 16 : 10);
    if (error == std::errc::result_out_of_range) return fail(Code::overflow, text);
    if (error != std::errc{} || end != digits.data() + digits.size()) return fail(Code::syntax, text);
    if (!negative) return Value(magnitude);
    if (magnitude > std::uint64_t{1} << 63) return fail(Code::overflow, text);
    return Value(static_cast<std::int64_t>(~magnitude + 1));
}

template <class Number>
std::string shortest(Number number) {
    std::array<char, 64> buffer;
    const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number);
    return error == std::errc{} ? std::string(buffer.data(), end) : std::string();
}

Result<Value> parse_as(DataType type, bool scaled, std::string_view text) {
    if (type == DataType::string) return Value(std::string(text));
    if (type == DataType::boolean) {
        if (text == "true" || text == "1") return Value(true);
        if (text == "false" || text == "0") return Value(false);
        return fail(Code::syntax, text);
    }
    if (type == DataType::float64 || scaled) {
        TAKT_TRY(const double number, parse_floating<double>(text));
        return Value(number);
    }
    if (type == DataType::float32) {
        TAKT_TRY(const float number, parse_floating<float>(text));
        return Value(double{number});
    }
    TAKT_TRY(const Value number, parse_integer(text));
    return convert(type, false, number);
}

/// The range of a type as users write it.
std::string allowed(DataType type, bool scaled) {
    if (type == DataType::boolean) return "true, false, 1, 0";
    if (scaled || type < DataType::int16 || type > DataType::uint64) return "1.5, -2e3, 16";
    const std::uint64_t all = ~std::uint64_t{0} >> (64 - 16 * register_count(type));
    const bool has_sign = type == DataType::int16 || type == DataType::int32 || type == DataType::int64;
    if (!has_sign) return "0.." + std::to_string(all);
    return "-" + std::to_string(all / 2 + 1) + ".." + std::to_string(all / 2);
}

}  // namespace

Result<Value> parse(DataType type, bool scaled, std::string_view text) {
    auto value = parse_as(type, scaled, text);
    if (value) return value;
    return fail(value.error().code, beside_allowed(text, allowed(type, scaled)));
}

std::string beside_allowed(std::string_view text, std::string_view allowed) {
    constexpr std::string_view kArrow = " → ";
    constexpr std::string_view kCut = "…";
    constexpr std::size_t kLongest = decltype(Error::subject)::capacity() - kArrow.size() - kCut.size();
    std::string subject(text);
    if (const auto most = kLongest - std::min(allowed.size(), kLongest); text.size() > most) {
        subject = whole_characters(text, most);
        subject += kCut;
    }
    return subject.append(kArrow).append(allowed);
}

std::string format(DataType type, bool scaled, const Value& value) {
    if (const auto* on = std::get_if<bool>(&value)) return *on ? "true" : "false";
    if (const auto* i = std::get_if<std::int64_t>(&value)) return shortest(*i);
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return shortest(*u);
    if (const auto* text = std::get_if<std::string>(&value)) return *text;
    const auto* number = std::get_if<double>(&value);
    if (!number) return {};
    return type == DataType::float32 && !scaled ? shortest(static_cast<float>(*number)) : shortest(*number);
}

}  // namespace takt::value
