// A block of lines at the end of a terminal that is redrawn in place.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace takt::report {

/// Rows and columns of a terminal.
struct Screen {
    std::size_t rows = 24;
    std::size_t columns = 80;
    friend bool operator==(const Screen&, const Screen&) = default;
};

/// Makes the text and the escape sequences (ECMA-48) that redraw the block; writes nothing itself. A terminal
/// that changes its size wraps its lines anew, and the block's position is lost: the screen is then cleared.
class Panel {
public:
    /// Replaces the lines drawn before by `lines`, each cut to the width of the screen.
    [[nodiscard]] std::string draw(const Screen& screen, const std::vector<std::string>& lines);

    /// Replaces the block by `text` (with its line end), which scrolls away. The block is gone until draw().
    [[nodiscard]] std::string above(const Screen& screen, const std::string& text);

private:
    [[nodiscard]] std::string back_up(const Screen& screen);

    Screen screen_;
    std::size_t drawn_ = 0;
};

}  // namespace takt::report
