#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace takt::model {

/// Least number of typing mistakes (a character wrong, missing, too much, or two swapped; capital letters
/// count half) that make one text of the other, times two. Only the first 64 bytes count.
std::size_t typing_distance(std::string_view a, std::string_view b);

/// The candidate nearest to `text`, the first one of equally near ones; empty without candidates. One that
/// holds the text, or is held by it, counts as two mistakes: "timeout" is near to "response_timeout".
std::string_view nearest(std::string_view text, std::span<const std::string_view> candidates);

}  // namespace takt::model
