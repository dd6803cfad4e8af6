// Text from outside (devices, files, peers) made safe for terminals, logs and line protocols.
#pragma once

#include <string>
#include <string_view>

namespace takt::text {

/// The text as one line of printable characters (takt/base/utf8.hpp) in valid UTF-8. Line feed, carriage
/// return and tab become `\n`, `\r`, `\t`; other unprintable characters `\u{9B}`; bytes that are not UTF-8
/// `\xFF`. A backslash stays as it is: the result is for people, not for parsing.
[[nodiscard]] std::string escape_line(std::string_view text);

/// escape_line() for a text of several lines: line feeds stay.
[[nodiscard]] std::string escape_lines(std::string_view text);

}  // namespace takt::text
