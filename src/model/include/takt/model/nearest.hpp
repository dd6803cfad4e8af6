#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace takt::model {

/// The edit distance of two texts, times two: each wrong, missing, additional or swapped character counts
/// two, a wrong case one. Only the first 64 bytes count.
std::size_t typing_distance(std::string_view a, std::string_view b);

/// Limit of the candidates among which names of a project are searched.
inline constexpr std::size_t kNamesToCompare = 500;

/// The candidate nearest to `text`, the first of equals; empty without candidates. A candidate that contains
/// the text, or is contained in it, counts as two mistakes: "timeout" is near to "response_timeout".
std::string_view nearest(std::string_view text, std::span<const std::string_view> candidates);

/// More than half of the text would have to be typed anew, and neither contains the other. The case of
/// letters does not count.
bool is_unlike(std::string_view text, std::string_view guess);

}  // namespace takt::model
