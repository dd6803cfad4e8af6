// Rows of CSV as in RFC 4180: a cell may be quoted, a quote inside is doubled, and a quoted cell may
// hold separators and line breaks.
#include "tables/csv_rows.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace takt::file {
namespace {

// Spreadsheets and web pages put spaces that do not break around a cell, and into an empty one.
std::string_view without_hard_spaces(std::string_view text) {
    constexpr std::string_view kHardSpace = "\u00A0";
    while (text.starts_with(kHardSpace)) text.remove_prefix(kHardSpace.size());
    while (text.ends_with(kHardSpace)) text.remove_suffix(kHardSpace.size());
    return text;
}

}  // namespace

bool Row::empty() const {
    // A line of separators is empty, whichever one the table has.
    return std::ranges::all_of(cells, [](const Cell& cell) {
        return cell.text.empty() ||
               (!cell.quoted && cell.text.find_first_not_of(";,\t ") == std::string::npos);
    });
}

RowReader::RowReader(const Source& source, std::size_t begin, char separator, Reporter& reporter)
    : source_(source),
      text_(source.text()),
      separator_(separator),
      blank_(separator == '\t' ? " " : " \t"),
      reporter_(reporter),
      at_(begin) {}

std::optional<Row> RowReader::next() {
    if (at_ >= text_.size()) return std::nullopt;
    Row row;
    do {
        auto next_cell = cell(row);
        const bool beyond = row.cells.size() >= kMaxColumns;
        if (!beyond || (row.cells.size() == kMaxColumns && !next_cell.text.empty()))
            row.cells.push_back(std::move(next_cell));
    } while (take(separator_));
    take('\r');
    take('\n');
    return row;
}

std::optional<Row> RowReader::next_filled() {
    auto row = next();
    while (row && row->empty() && !row->damaged) row = next();
    return row;
}

bool RowReader::take(char c) {
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
}

std::size_t RowReader::end_of_plain() const {
    const std::array<char, 4> ends{separator_, '\r', '\n', '\0'};
    return std::min(text_.find_first_of(ends.data(), at_), text_.size());
}

Cell RowReader::cell(Row& row) {
    at_ = std::min(text_.find_first_not_of(blank_, at_), text_.size());
    Cell cell{at_, {}, take('"')};
    if (cell.quoted) cell.text = quoted(row, cell.offset);
    const auto plain = text_.substr(at_, end_of_plain() - at_);
    const auto trimmed = without_hard_spaces(plain.substr(0, plain.find_last_not_of(blank_) + 1));
    if (!cell.quoted) {
        cell.text = trimmed;
    } else if (!trimmed.empty()) {
        damage(row, "file.csv.after_quote", at_ + trimmed.find_first_not_of(blank_));
    }
    at_ += plain.size();
    return cell;
}

std::string RowReader::quoted(Row& row, std::size_t open) {
    std::string text;
    for (;;) {
        const auto quote = text_.find('"', at_);
        text += text_.substr(at_, quote - at_);
        at_ = std::min(quote, text_.size());
        if (!take('"')) {
            damage(row, "file.csv.unclosed_quote", open);
            return text;
        }
        if (!take('"')) return text;
        text += '"';
    }
}

void RowReader::damage(Row& row, std::string_view code, std::size_t offset) {
    reporter_.error(code, source_.location(offset));
    row.damaged = true;
}

}  // namespace takt::file
