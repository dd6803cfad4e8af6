// Text from outside (devices, files, peers) made safe for terminals, logs and line protocols.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace takt::text {

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

/// The text as one line of printable characters in valid UTF-8. Line feed, carriage return and tab become
/// `\n`, `\r`, `\t`; other unprintable characters `\u{9B}`; bytes that are not UTF-8 `\xFF`. A backslash stays
/// as it is: the result is for people, not for parsing.
[[nodiscard]] std::string escape_line(std::string_view text);

/// escape_line() for a text of several lines: line feeds stay.
[[nodiscard]] std::string escape_lines(std::string_view text);

}  // namespace takt::text
