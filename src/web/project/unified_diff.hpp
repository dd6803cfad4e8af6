// Differences of two texts.
#pragma once

#include <string>
#include <string_view>

namespace takt::web {

/// The unified format of POSIX diff, with three lines of context; empty where the texts are equal. The
/// shortest difference (Myers, "An O(ND) Difference Algorithm", 1986) of up to kMostDifferences lines;
/// beyond, all lines between the first and the last difference are replaced.
/// @param before, after  names for the two heading lines
[[nodiscard]] std::string unified_diff(std::string_view old_text, std::string_view new_text,
                                       std::string_view before, std::string_view after);

inline constexpr int kMostDifferences = 1500;

}  // namespace takt::web
