#include "takt/app/text_table.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"

namespace takt::app {
namespace {

constexpr bool starts_character(char byte) {
    return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U;
}

}  // namespace

std::size_t display_width(std::string_view text) {
    return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), starts_character));
}

std::string fitted(std::string_view text, std::size_t width) {
    if (display_width(text) <= width) return std::string(text);
    std::string cut;
    std::size_t characters = 0;
    for (const char byte : text) {
        if (starts_character(byte) && ++characters == width) break;
        cut += byte;
    }
    return width == 0 ? std::string() : cut + "…";
}

void TextTable::add(std::vector<std::string> cells) {
    TAKT_ASSERT(cells.size() <= columns_.size());
    rows_.push_back(std::move(cells));
}

std::vector<std::string> TextTable::lines() const {
    std::vector<std::size_t> widths(columns_.size());
    for (const auto& row : rows_)
        for (std::size_t column = 0; column < row.size(); ++column)
            widths[column] = std::max(widths[column], display_width(row[column]));
    std::vector<std::string> lines;
    for (const auto& row : rows_) {
        std::string line;
        for (std::size_t column = 0; column < row.size(); ++column) {
            const std::string padding(widths[column] - display_width(row[column]), ' ');
            if (column > 0) line += "  ";
            line += columns_[column] == Align::right ? padding + row[column] : row[column] + padding;
        }
        line.erase(line.find_last_not_of(' ') + 1);
        lines.push_back(std::move(line));
    }
    return lines;
}

std::string TextTable::render(std::string_view indent) const {
    std::string text;
    for (const auto& line : lines()) text += std::string(indent) + line + '\n';
    return text;
}

}  // namespace takt::app
