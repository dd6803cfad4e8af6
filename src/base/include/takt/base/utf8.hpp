// Characters of UTF-8 text.
#pragma once

#include <cstddef>
#include <string_view>

namespace takt {

/// A character at the front of a text.
struct Character {
    char32_t code = 0;
    std::size_t bytes = 0;  ///< 0: the text does not begin with valid UTF-8 (RFC 3629)
};

/// @param text  not empty
[[nodiscard]] Character first_character(std::string_view text);

/// Whether a terminal or an editor shows the character as itself: no control character (C0, DEL, C1), no line
/// or paragraph separator, no bidirectional control (Unicode Standard Annex #9), which could reverse what is
/// shown after it.
[[nodiscard]] bool is_printable(char32_t code);

}  // namespace takt
