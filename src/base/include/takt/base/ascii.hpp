// Characters of text formats, without a locale.
#pragma once

#include <algorithm>
#include <optional>
#include <string_view>

namespace takt {

[[nodiscard]] constexpr bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

[[nodiscard]] constexpr char lower_case(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

/// 0 to 15 as a digit: 0 to 9, A to F.
[[nodiscard]] constexpr char hex_digit(unsigned value) {
    return "0123456789ABCDEF"[value & 0xFU];
}

/// The value of a hexadecimal digit of either case; nothing for another character.
[[nodiscard]] constexpr std::optional<unsigned> hex_value(char c) {
    if (is_digit(c)) return static_cast<unsigned>(c - '0');
    const char small = lower_case(c);
    if (small < 'a' || small > 'f') return std::nullopt;
    return static_cast<unsigned>(small - 'a') + 10U;
}

/// Whether `text` is a decimal number without a sign. Empty text is none.
[[nodiscard]] constexpr bool all_digits(std::string_view text) {
    return !text.empty() && std::ranges::all_of(text, is_digit);
}

/// `text` without any of the characters `blanks` at its ends.
[[nodiscard]] constexpr std::string_view trimmed(std::string_view text, std::string_view blanks = " ") {
    text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
    return text.substr(0, text.find_last_not_of(blanks) + 1);
}

}  // namespace takt
