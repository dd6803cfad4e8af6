// The reference for plans, independent of the planner: costs computed anew from docs/planning.md, "Bus time",
// in seconds as long double, and least covers by a partition of the sorted values.
#pragma once

#include <span>
#include <vector>

#include "maps.hpp"

namespace corpus {

using Seconds = long double;

/// Items start <= i < end of one function, read at once.
struct Read {
    std::uint32_t start = 0;
    std::uint32_t end = 0;
};

/// Of one function of one device on one bus.
struct Rules {
    Bus bus;
    int function = 3;
    std::uint32_t limit = 125;  ///< most items of a request
    bool gaps = true;           ///< items that are not requested may be read

    [[nodiscard]] Seconds cost(std::uint32_t items) const;
};

[[nodiscard]] Rules rules_of(const Map& map, int function, const Bus& bus, bool gaps);

[[nodiscard]] Seconds total(const std::vector<Read>& reads, const Rules& rules);

/// Reads of least total cost in which each value lies whole. O(n * values in a request).
[[nodiscard]] std::vector<Read> least_reads(std::vector<Value> values, const Rules& rules);

/// Neighbours share a request while at most `gap` items lie between them, as many masters do.
[[nodiscard]] std::vector<Read> fixed_gap_reads(std::vector<Value> values, const Rules& rules,
                                                std::uint32_t gap);

/// The cost of the best of all partitions of at most eight values, tried one by one.
[[nodiscard]] Seconds least_cost_by_trying(std::span<const Value> values, const Rules& rules);

/// Seconds of bus time a second when everything of a period is read at once, in phase.
struct Rates {
    Seconds per_class = 0;  ///< each period by itself
    Seconds aligned = 0;    ///< at each tick what is due then, together
};
[[nodiscard]] Rates least_rates(const std::vector<Value>& values, const Rules& rules);

}  // namespace corpus
