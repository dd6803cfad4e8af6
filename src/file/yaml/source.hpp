// The text of one file: allowed characters and locations of its bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/model/document.hpp"

namespace takt::file {

class Source {
public:
    /// Keeps a view of `text`, without the byte order mark at its start.
    Source(std::uint32_t file, std::string_view text);

    [[nodiscard]] std::string_view text() const { return text_; }
    [[nodiscard]] std::uint32_t file() const { return file_; }

    /// The location of the byte at `offset`; the column counts characters. Beyond the end: the location
    /// behind the last character.
    [[nodiscard]] model::SourceLocation location(std::size_t offset) const;

    /// Whether the text at `offset` begins with `text`.
    [[nodiscard]] bool stands_at(std::size_t offset, std::string_view text) const;

    /// The character at `offset`; empty at the end.
    [[nodiscard]] std::string_view character(std::size_t offset) const;

private:
    [[nodiscard]] std::size_t characters_before(std::size_t offset) const;
    [[nodiscard]] std::size_t line_of(std::size_t offset) const;

    std::uint32_t file_;
    std::string_view text_;
    std::vector<std::size_t> lines_;  // offset of each line's first byte
    // Characters before each block, so that a long line costs no more than a short one. Empty: all ASCII.
    std::vector<std::size_t> characters_;
    mutable std::size_t last_line_ = 0;  // of the previous location: most are asked for in ascending order
};

inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// A byte or character that a text file must not contain, with its offset.
struct Foreign {
    std::size_t offset = 0;
    bool utf8 = true;         ///< false: the byte there is not UTF-8
    std::uint32_t value = 0;  ///< that byte, or the character that is refused
};

/// The first invalid byte of UTF-8 or the first control character other than tab and line break. A lone
/// carriage return counts (a line break in YAML that yaml-cpp drops), and so does a byte order mark.
std::optional<Foreign> find_foreign(std::string_view text);

/// "0xFF" for a byte, "U+0000" for a character.
std::string in_words(const Foreign& foreign);

}  // namespace takt::file
