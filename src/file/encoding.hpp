// Tables come in UTF-8 or in CP1251, the code page of Cyrillic Windows.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "source.hpp"
#include "takt/file/table.hpp"

namespace takt::file {

/// Which of the two some bytes are in: UTF-8 when they begin with its mark, or when no more of their bytes
/// are wrong there than characters beyond ASCII are right (a damaged file is to be reported, not turned into
/// other letters); else CP1251.
Encoding encoding_of(std::string_view bytes);

struct Decoded {
    std::string text;                   ///< up to the byte where it stopped
    std::optional<Foreign> stopped_at;  ///< a byte that is none in CP1251; its offset counts in `text`
};

/// UTF-8 stays as it is, unchecked.
Decoded to_utf8(std::string_view bytes, Encoding encoding);

/// Nothing when a character of the text is not in CP1251.
std::optional<std::string> to_cp1251(std::string_view text);

/// The first character that is not in CP1251; empty when all are.
std::string_view first_beyond_cp1251(std::string_view text);

}  // namespace takt::file
