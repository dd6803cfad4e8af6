#include "takt/model/item_ranges.hpp"

#include <algorithm>
#include <iterator>

namespace takt::model {
namespace {

std::uint32_t end_of(const ItemRange& range) {
    return std::uint32_t{range.last} + 1;
}

ItemRange range_of(std::uint32_t first, std::uint32_t end) {
    return {static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(end - 1)};
}

}  // namespace

ItemRanges united(const ItemRanges& a, const ItemRanges& b) {
    ItemRanges all;
    std::ranges::merge(a, b, std::back_inserter(all), {}, &ItemRange::first, &ItemRange::first);
    ItemRanges runs;
    for (const ItemRange& range : all) {
        if (runs.empty() || end_of(runs.back()) < range.first)
            runs.push_back(range);
        else
            runs.back().last = std::max(runs.back().last, range.last);
    }
    return runs;
}

ItemRanges without(const ItemRanges& from, const ItemRanges& what) {
    ItemRanges left;
    auto hole = what.begin();
    for (const ItemRange& range : from) {
        std::uint32_t first = range.first;
        while (hole != what.end() && hole->last < first) ++hole;
        for (auto at = hole; at != what.end() && at->first <= range.last; ++at) {
            if (at->first > first) left.push_back(range_of(first, at->first));
            first = end_of(*at);
        }
        if (first < end_of(range)) left.push_back(range_of(first, end_of(range)));
    }
    return left;
}

ItemRanges all_but(const ItemRanges& ranges) {
    return without({range_of(0, kItemsPerArea)}, ranges);
}

bool holds(const ItemRanges& ranges, const ItemRange& range) {
    return std::ranges::any_of(
        ranges, [&](const ItemRange& r) { return r.first <= range.first && range.last <= r.last; });
}

}  // namespace takt::model
