// Long lines of text on a terminal.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace takt::report {

/// The text with each line of more than `columns` characters broken at blanks. The rest of a line is indented
/// by four blanks more than its beginning, or as its second column. A word longer than a line stays whole,
/// and a number keeps its unit. Other lines do not change.
[[nodiscard]] std::string wrapped(std::string_view text, std::size_t columns);

}  // namespace takt::report
