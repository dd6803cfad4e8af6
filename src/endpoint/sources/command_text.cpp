#include "sources/command_text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <variant>

#include "takt/base/ascii.hpp"

namespace takt::endpoint {
namespace {

using Kind = model::TextTemplate::Kind;

constexpr std::string_view kPunctuation = " ._+-/";

bool is_harmless(char c) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    return letter || is_digit(c) || kPunctuation.contains(c);
}

/// An integer that is not a floating-point number, with its sign.
struct Integer {
    bool negative = false;
    std::uint64_t magnitude = 0;
};

std::optional<Integer> as_integer(const value::Value& value) {
    if (const auto* const on = std::get_if<bool>(&value)) return Integer{false, *on ? 1U : 0U};
    if (const auto* const number = std::get_if<std::uint64_t>(&value)) return Integer{false, *number};
    const auto* const number = std::get_if<std::int64_t>(&value);
    if (number == nullptr) return std::nullopt;
    const auto bits = static_cast<std::uint64_t>(*number);
    return Integer{*number < 0, *number < 0 ? ~bits + 1 : bits};
}

template <class Number, class... More>
std::string to_text(Number number, More... more) {
    std::array<char, 400> buffer{};  // a double has at most 309 digits before the point
    const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number, more...);
    return error == std::errc() ? std::string(buffer.data(), end) : std::string();
}

/// Without a sign.
std::string real_text(double magnitude, std::optional<std::uint8_t> decimals) {
    if (decimals) return to_text(magnitude, std::chars_format::fixed, *decimals);
    const auto single = static_cast<float>(magnitude);
    if (static_cast<double>(single) == magnitude) return to_text(single, std::chars_format::fixed);
    return to_text(magnitude, std::chars_format::fixed);
}

/// With zeros up to the number of digits before the point, and the sign unless the value is 0.
std::string completed(std::string text, bool negative, std::uint8_t digits) {
    const auto whole = std::min(text.find('.'), text.size());
    if (whole < digits) text.insert(0, digits - whole, '0');
    if (negative && text.find_first_not_of("0.") != std::string::npos) text.insert(0, 1, '-');
    return text;
}

std::optional<std::string> number_text(const model::NumberFormat& format, const value::Value& value) {
    if (const auto integer = as_integer(value)) {
        std::string text = to_text(integer->magnitude);
        if (format.decimals.value_or(0) > 0) text += '.' + std::string(*format.decimals, '0');
        return completed(std::move(text), integer->negative, format.digits);
    }
    const auto* const real = std::get_if<double>(&value);
    if (real == nullptr || !std::isfinite(*real)) return std::nullopt;
    return completed(real_text(std::abs(*real), format.decimals), *real < 0, format.digits);
}

std::optional<std::string> hex_text(const model::NumberFormat& format, const value::Value& value) {
    constexpr double kBeyond = 18446744073709551616.0;
    auto integer = as_integer(value);
    if (const auto* const real = std::get_if<double>(&value)) {
        if (!(*real >= 0 && *real < kBeyond) || std::trunc(*real) != *real) return std::nullopt;
        integer = Integer{false, static_cast<std::uint64_t>(*real)};
    }
    if (!integer || integer->negative) return std::nullopt;
    std::string text = to_text(integer->magnitude, 16);
    std::ranges::transform(text, text.begin(), [](char c) {
        return c >= 'a' && c <= 'f' ? static_cast<char>(c - 'a' + 'A') : c;
    });
    return completed(std::move(text), false, format.digits);
}

std::optional<double> as_real(const value::Value& value) {
    if (const auto* const real = std::get_if<double>(&value)) return *real;
    const auto integer = as_integer(value);
    if (!integer) return std::nullopt;
    const auto magnitude = static_cast<double>(integer->magnitude);
    return integer->negative ? -magnitude : magnitude;
}

bool in_range(const model::NumberFormat& format, const value::Value& value) {
    const auto number = as_real(value);
    if (!number) return true;  // a text
    return !(format.least && !(*number >= *format.least)) &&
           !(format.greatest && !(*number <= *format.greatest));
}

/// The byte behind the placeholder, at which an instrument ends the value.
std::optional<char> byte_behind(const model::TextTemplate& request) {
    const auto value =
        std::ranges::find_if(request.pieces, [](const auto& p) { return p.kind != Kind::literal; });
    if (value == request.pieces.end() || value + 1 == request.pieces.end()) return std::nullopt;
    return (value + 1)->text.front();
}

}  // namespace

std::optional<std::string> value_text(const model::InstrumentCommand& command, const value::Value& value) {
    switch (command.kind()) {
        case Kind::text: {
            const auto* const text = std::get_if<std::string>(&value);
            return text ? std::optional(std::string(trimmed(*text))) : std::nullopt;
        }
        case Kind::hex: return hex_text(command.format, value);
        default: return number_text(command.format, value);
    }
}

Result<std::string> command_text(const model::InstrumentCommand& command, const value::Value& value) {
    const auto text = value_text(command, value);
    if (!text || text->empty() || text->size() > kMostValueText || !in_range(command.format, value))
        return fail(Code::out_of_range);
    if (command.kind() != Kind::text) return *text;
    const auto end = byte_behind(command.request);
    if (!std::ranges::all_of(*text, is_harmless) || (end && text->contains(*end)))
        return fail(Code::out_of_range);
    return *text;
}

std::string command_bytes(const model::InstrumentCommand& command, const std::string& text) {
    std::string bytes;
    for (const auto& piece : command.request.pieces) bytes += piece.kind == Kind::literal ? piece.text : text;
    return bytes;
}

}  // namespace takt::endpoint
