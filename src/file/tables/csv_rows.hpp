// Splits a text into rows of cells.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "yaml/reporter.hpp"
#include "yaml/source.hpp"

namespace takt::file {

inline constexpr std::size_t kMaxColumns = 256;

struct Cell {
    std::size_t offset = 0;
    std::string text;
    bool quoted = false;
};

struct Row {
    std::vector<Cell> cells;  ///< beyond kMaxColumns at most one more, if it is not empty
    bool damaged = false;     ///< and reported

    [[nodiscard]] bool empty() const;
};

/// RFC 4180 with any separator. A quoted cell may hold separators, line breaks and doubled quotes. Spaces
/// around cells are ignored. A quote inside an unquoted cell is an ordinary character.
class RowReader {
public:
    RowReader(const Source& source, std::size_t begin, char separator, Reporter& reporter);

    /// The next row; nothing at the end.
    std::optional<Row> next();
    /// The next row that is not empty.
    std::optional<Row> next_filled();
    /// The offset of the next row.
    [[nodiscard]] std::size_t offset() const { return at_; }

private:
    bool take(char c);
    [[nodiscard]] std::size_t end_of_plain() const;
    Cell cell(Row& row);
    std::string quoted(Row& row, std::size_t open);
    void damage(Row& row, std::string_view code, std::size_t offset);

    const Source& source_;
    std::string_view text_;
    char separator_;
    std::string_view blank_;
    Reporter& reporter_;
    std::size_t at_;
};

}  // namespace takt::file
