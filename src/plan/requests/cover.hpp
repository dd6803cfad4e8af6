// Minimum-cost requests for given items of one device and function.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cost/request_cost.hpp"

namespace takt::plan {

/// Items start <= i < end of one area, registers or bits; not empty, end at most 65536.
struct Span {
    std::uint32_t start = 0;
    std::uint32_t end = 0;

    [[nodiscard]] std::uint32_t size() const { return end - start; }
    friend bool operator==(const Span&, const Span&) = default;
};

/// One request. The given spans `first`..`last` lie in `items`, possibly others too.
struct Window {
    Span items;
    std::size_t first = 0;
    std::size_t last = 0;
    friend bool operator==(const Window&, const Window&) = default;
};

/// The limits of requests of that device and function.
struct CoverRules {
    RequestCost cost;
    std::uint32_t limit = 1;  ///< most items of a request, at least 1
    /// Runs of readable items: ascending, disjoint, not adjoining. Each request lies in one of them.
    std::span<const Span> readable;
};

/// A cover of least total cost: each span lies completely in a request. Ties: the fewest requests, then the
/// shortest last requests. Ascending start and end. O(n * unit).
/// @param spans  ordered by start, then end; may overlap, contain each other and be equal; each at most
///               `limit` long and inside one readable run
[[nodiscard]] std::vector<Window> cover(std::span<const Span> spans, const CoverRules& rules);

/// The union of `spans` (ordered by start) as runs of items.
[[nodiscard]] std::vector<Span> united(std::span<const Span> spans);

}  // namespace takt::plan
