// Text in aligned columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace takt::report {

/// The number of characters of UTF-8 text, each taken as one column of a terminal. Combining and wide
/// characters are not treated specially.
[[nodiscard]] std::size_t display_width(std::string_view text);

/// The text cut to `width` characters; "…" is the last one of a text that was cut.
[[nodiscard]] std::string fitted(std::string_view text, std::size_t width);

/// Rows of cells; every column is as wide as its widest cell. A column may be aligned to the right (numbers).
class TextTable {
public:
    enum class Align : std::uint8_t {
        left,
        right,
        whole,  ///< left, and never cut
    };

    /// One entry a column; a row may have fewer cells, not more.
    explicit TextTable(std::vector<Align> columns) : columns_(std::move(columns)) {}

    void add(std::vector<std::string> cells);

    /// A line of text for each row, without line ends. Lines longer than `most` characters are shortened: the
    /// columns with Align::left are cut, the widest first, down to six characters. Numbers are never cut.
    [[nodiscard]] std::vector<std::string> lines(std::size_t most = SIZE_MAX) const;

    /// The lines as one text, each with its line end. Columns are two blanks apart; there are no blanks at
    /// line ends.
    /// @param most  characters of a line with its indent, as of lines()
    [[nodiscard]] std::string render(std::string_view indent = "", std::size_t most = SIZE_MAX) const;

private:
    [[nodiscard]] std::vector<std::size_t> widths(std::size_t most) const;

    std::vector<Align> columns_;
    std::vector<std::vector<std::string>> rows_;
};

}  // namespace takt::report
