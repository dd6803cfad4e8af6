// The requests of least cost that read given items of one device, function and time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "request_cost.hpp"

namespace takt::plan {

/// Items start <= i < end of one area, registers or bits; not empty, end at most 65536.
struct Span {
    std::uint32_t start = 0;
    std::uint32_t end = 0;

    [[nodiscard]] std::uint32_t size() const { return end - start; }
    friend bool operator==(const Span&, const Span&) = default;
};

/// One request: spans `first` to `last` of those given, both included, lie in `items`; others may as well.
struct Window {
    Span items;
    std::size_t first = 0;
    std::size_t last = 0;
    friend bool operator==(const Window&, const Window&) = default;
};

/// What a request of that device and function must keep to.
struct CoverRules {
    RequestCost cost;
    std::uint32_t limit = 1;  ///< most items of a request, at least 1
    /// Runs of items that may be read; ascending, neither overlapping nor adjoining. A request lies in one.
    std::span<const Span> readable;
};

/// The requests of least total cost such that each span lies in one of them whole; among those the fewest;
/// among those the ones with the last requests shortest. In ascending order of start and of end. O(n * unit).
/// @param spans  by start, then end; may overlap, contain each other and be equal; each at most `limit` long
/// and inside one readable run
[[nodiscard]] std::vector<Window> cover(std::span<const Span> spans, const CoverRules& rules);

/// The runs of items that `spans` (by start) occupy.
[[nodiscard]] std::vector<Span> united(std::span<const Span> spans);

}  // namespace takt::plan
