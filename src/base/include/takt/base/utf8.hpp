// Characters of UTF-8 text.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "takt/base/inplace_string.hpp"

namespace takt {

/// A character at the front of a text.
struct Character {
    char32_t code = 0;
    std::size_t bytes = 0;  ///< 0: the text does not begin with valid UTF-8 (RFC 3629)
};

/// @param text  not empty
[[nodiscard]] Character first_character(std::string_view text);

/// The character in UTF-8.
/// @param code  at most U+10FFFF, no surrogate
[[nodiscard]] InplaceString<4> encoded(char32_t code);

/// Whether the byte is one of a character's bytes behind its first one.
[[nodiscard]] constexpr bool continues_character(char byte) {
    return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U;
}

/// The number of code points of a text in valid UTF-8.
[[nodiscard]] constexpr std::size_t count_characters(std::string_view text) {
    return text.size() - static_cast<std::size_t>(std::ranges::count_if(text, continues_character));
}

/// The longest front of a text in valid UTF-8 that has at most `most` bytes and ends with a whole character.
[[nodiscard]] constexpr std::string_view whole_characters(std::string_view text, std::size_t most) {
    if (text.size() <= most) return text;
    while (most > 0 && continues_character(text[most])) --most;
    return text.substr(0, most);
}

/// Whether a terminal or an editor shows the character as itself: no control character (C0, DEL, C1), no line
/// or paragraph separator, no bidirectional control (Unicode Standard Annex #9), which could reverse what is
/// shown after it.
[[nodiscard]] bool is_printable(char32_t code);

}  // namespace takt
