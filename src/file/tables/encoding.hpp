// Encodings of tables: UTF-8, or CP1251, the code page of Cyrillic Windows.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "takt/file/table.hpp"
#include "yaml/source.hpp"

namespace takt::file {

/// Detects the encoding: UTF-8 if the bytes begin with its byte order mark, or if they hold at least as many
/// valid characters beyond ASCII as invalid bytes; else CP1251. So a slightly damaged UTF-8 file is reported,
/// not decoded as CP1251.
Encoding encoding_of(std::string_view bytes);

struct Decoded {
    std::string text;                   ///< up to the byte where it stopped
    std::optional<Foreign> stopped_at;  ///< a byte that is none in CP1251; its offset counts in `text`
};

/// UTF-8 is passed on unchecked.
Decoded to_utf8(std::string_view bytes, Encoding encoding);

/// Nothing if a character of the text does not exist in CP1251.
std::optional<std::string> to_cp1251(std::string_view text);

/// The first character that does not exist in CP1251; empty if all do.
std::string_view first_beyond_cp1251(std::string_view text);

}  // namespace takt::file
