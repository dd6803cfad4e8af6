// Columns of text, aligned.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace takt::report {

/// Characters a terminal shows for UTF-8 text, one column each (combining and wide characters are not told
/// apart).
[[nodiscard]] std::size_t display_width(std::string_view text);

/// The text cut to `width` characters, with "…" as the last where something was cut.
[[nodiscard]] std::string fitted(std::string_view text, std::size_t width);

/// Rows of cells; every column is as wide as its widest cell. A column may be aligned to the right (numbers).
class TextTable {
public:
    enum class Align : bool { left, right };

    /// One entry a column; a row may have fewer cells, not more.
    explicit TextTable(std::vector<Align> columns) : columns_(std::move(columns)) {}

    void add(std::vector<std::string> cells);

    /// A line of text for each row, without line ends. Where they would be longer than `most` characters,
    /// columns of words (those aligned to the left) are cut, the widest first, as far as some of the word
    /// stays; numbers never are.
    [[nodiscard]] std::vector<std::string> lines(std::size_t most = SIZE_MAX) const;

    /// The same as one text: lines, each with its line end, two blanks between columns, no blanks at line
    /// ends.
    [[nodiscard]] std::string render(std::string_view indent = "") const;

private:
    [[nodiscard]] std::vector<std::size_t> widths(std::size_t most) const;

    std::vector<Align> columns_;
    std::vector<std::vector<std::string>> rows_;
};

}  // namespace takt::report
