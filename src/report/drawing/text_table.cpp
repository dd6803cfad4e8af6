#include "takt/report/drawing/text_table.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"
#include "takt/base/utf8.hpp"
#include "takt/text/escape.hpp"

namespace takt::report {
namespace {

constexpr std::size_t kBetween = 2;
constexpr std::size_t kLeastWords = 6;

}  // namespace

std::size_t display_width(std::string_view text) {
    return count_characters(text);
}

std::string fitted(std::string_view text, std::size_t width) {
    if (display_width(text) <= width) return std::string(text);
    std::string cut;
    std::size_t characters = 0;
    for (const char byte : text) {
        if (!continues_character(byte) && ++characters == width) break;
        cut += byte;
    }
    return width == 0 ? std::string() : cut + "…";
}

void TextTable::add(std::vector<std::string> cells) {
    TAKT_ASSERT(cells.size() <= columns_.size());
    for (auto& cell : cells) cell = text::escape_line(cell);
    rows_.push_back(std::move(cells));
}

std::vector<std::size_t> TextTable::widths(std::size_t most) const {
    std::vector<std::size_t> widths(columns_.size());
    for (const auto& row : rows_)
        for (std::size_t column = 0; column < row.size(); ++column)
            widths[column] = std::max(widths[column], display_width(row[column]));
    std::size_t total = columns_.empty() ? 0 : kBetween * (columns_.size() - 1);
    for (const auto width : widths) total += width;
    while (total > most) {
        std::size_t widest = columns_.size();
        for (std::size_t column = 0; column < columns_.size(); ++column)
            if (columns_[column] == Align::left && widths[column] > kLeastWords &&
                (widest == columns_.size() || widths[column] > widths[widest]))
                widest = column;
        if (widest == columns_.size()) break;
        --widths[widest];
        --total;
    }
    return widths;
}

std::vector<std::string> TextTable::lines(std::size_t most) const {
    const auto widths = this->widths(most);
    std::vector<std::string> lines;
    for (const auto& row : rows_) {
        std::string line;
        for (std::size_t column = 0; column < row.size(); ++column) {
            const auto cell = fitted(row[column], widths[column]);
            const std::string padding(widths[column] - display_width(cell), ' ');
            if (column > 0) line += std::string(kBetween, ' ');
            line += columns_[column] == Align::right ? padding + cell : cell + padding;
        }
        line.erase(line.find_last_not_of(' ') + 1);
        lines.push_back(std::move(line));
    }
    return lines;
}

std::string TextTable::render(std::string_view indent, std::size_t most) const {
    std::string text;
    for (const auto& line : lines(most - std::min(most, indent.size())))
        text += std::string(indent) + line + '\n';
    return text;
}

}  // namespace takt::report
