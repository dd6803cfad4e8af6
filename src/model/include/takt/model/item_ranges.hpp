// Sets of items as ranges: ascending, disjoint, not adjoining.
#pragma once

#include <cstdint>
#include <vector>

#include "takt/model/project.hpp"

namespace takt::model {

/// Items are numbered 0..65535.
inline constexpr std::uint32_t kItemsPerArea = 65536;

using ItemRanges = std::vector<ItemRange>;

/// The union of two sets.
[[nodiscard]] ItemRanges united(const ItemRanges& a, const ItemRanges& b);

/// The items of `from` that are not in `what`.
[[nodiscard]] ItemRanges without(const ItemRanges& from, const ItemRanges& what);

/// All items 0..65535 but these.
[[nodiscard]] ItemRanges all_but(const ItemRanges& ranges);

/// Whether every item of `range` is in `ranges`.
[[nodiscard]] bool holds(const ItemRanges& ranges, const ItemRange& range);

[[nodiscard]] constexpr bool overlap(const ItemRange& a, const ItemRange& b) {
    return a.first <= b.last && b.first <= a.last;
}

}  // namespace takt::model
