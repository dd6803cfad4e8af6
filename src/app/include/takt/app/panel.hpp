// Lines that stand in place on a terminal, at the end of what is written there.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace takt::app {

/// Rows and columns of a terminal.
struct Screen {
    std::size_t rows = 24;
    std::size_t columns = 80;
    friend bool operator==(const Screen&, const Screen&) = default;
};

/// Of the terminal behind `descriptor`; 24 × 80 where it does not say.
[[nodiscard]] Screen screen_of(int descriptor);

/// Says what to write to the terminal; writes nothing itself. A terminal that changes its size wraps what
/// stands on it anew, so that nobody knows where it is: then the screen is cleared.
class Panel {
public:
    /// What to write so that `lines` stand where those before stood, each cut to the width of the screen.
    [[nodiscard]] std::string draw(const Screen& screen, const std::vector<std::string>& lines);

    /// What to write so that `text` (with its line end) stands above, and scrolls away; the lines are gone
    /// until they are drawn again.
    [[nodiscard]] std::string above(const Screen& screen, const std::string& text);

private:
    [[nodiscard]] std::string back_up(const Screen& screen);

    Screen screen_;
    std::size_t drawn_ = 0;
};

}  // namespace takt::app
