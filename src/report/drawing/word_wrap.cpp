#include "takt/report/drawing/word_wrap.hpp"

#include <algorithm>

#include "takt/base/ascii.hpp"
#include "takt/report/drawing/text_table.hpp"

namespace takt::report {
namespace {

constexpr std::size_t kHanging = 4;

/// A number keeps its unit, and a comment its first word.
bool binds(char before) {
    return is_digit(before) || before == '#';
}

/// The blank at which a long line ends: the last one with which it fits, else the first one; npos: none.
/// @param indent  blanks at the beginning, which are no place to break
std::size_t break_of(std::string_view line, std::size_t indent, std::size_t columns) {
    std::size_t found = std::string_view::npos;
    for (auto at = line.find(' ', indent); at != std::string_view::npos;
         at = line.find(' ', line.find_first_not_of(' ', at))) {
        if (binds(line[at - 1])) continue;
        const bool fits = display_width(line.substr(0, at)) <= columns;
        if (fits || found == std::string_view::npos) found = at;
        if (!fits) break;
    }
    return found;
}

/// Where the rest of a line begins: below its second column (two blanks or more are before it), if that is in
/// the left half, else somewhat to the right of its beginning.
std::size_t hanging_indent(std::string_view line, std::size_t indent, std::size_t columns) {
    const auto gap = line.find("  ", indent);
    const auto second = gap == std::string_view::npos ? gap : line.find_first_not_of(' ', gap);
    if (second == std::string_view::npos) return indent + kHanging;
    const auto column = display_width(line.substr(0, second));
    return column <= columns / 2 ? column : indent + kHanging;
}

void append_line(std::string& text, std::string_view line, std::size_t columns) {
    const std::size_t indent = std::min(line.find_first_not_of(' '), line.size());
    const std::string hanging(hanging_indent(line, indent, columns), ' ');
    std::string rest(line);
    std::size_t begin = indent;
    while (display_width(rest) > columns) {
        const auto at = break_of(rest, begin, columns);
        const auto next = at == std::string::npos ? at : rest.find_first_not_of(' ', at);
        if (next == std::string::npos) break;
        text.append(rest, 0, at) += '\n';
        rest = hanging + rest.substr(next);
        begin = hanging.size();
    }
    text += rest;
}

}  // namespace

std::string wrapped(std::string_view text, std::size_t columns) {
    std::string result;
    while (!text.empty()) {
        const auto end = text.find('\n');
        append_line(result, text.substr(0, end), columns);
        if (end == std::string_view::npos) break;
        result += '\n';
        text.remove_prefix(end + 1);
    }
    return result;
}

}  // namespace takt::report
