#include "takt/report/drawing/panel.hpp"

#include <fmt/format.h>

#include <utility>

#include "takt/report/drawing/text_table.hpp"
#include "takt/text/escape.hpp"

namespace takt::report {

std::string Panel::draw(const Screen& screen, const std::vector<std::string>& lines) {
    std::string text = back_up(screen);
    for (const auto& line : lines) text += fitted(text::escape_line(line), screen.columns - 1) + "\x1b[K\n";
    drawn_ = lines.size();
    return text + "\x1b[J";
}

std::string Panel::above(const Screen& screen, const std::string& text) {
    auto written = back_up(screen) + "\x1b[J" + text::escape_lines(text);
    drawn_ = 0;
    return written;
}

std::string Panel::back_up(const Screen& screen) {
    const bool wrapped = drawn_ > 0 && screen != screen_;
    screen_ = screen;
    if (wrapped) return "\x1b[H\x1b[2J";
    return drawn_ > 0 ? fmt::format("\x1b[{}A\r", drawn_) : std::string();
}

}  // namespace takt::report
