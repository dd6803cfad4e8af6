// Compares a plan with plans of the same project by each strategy.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// The cost of the requests of one line. With several periods only the figures per second are comparable: a
/// request of a stream (Request::stream) is sent less often than its period demands.
struct Cost {
    std::size_t requests = 0;        ///< RequestCounts::grouped
    std::uint64_t bytes = 0;         ///< characters on the line, each read and each write once, both ways
    Duration bus_time{};             ///< of each read and each write once
    Duration cycle{};                ///< of one round of the polled entries alone
    double utilization = 0;          ///< busy() of the plan
    bool saturated = false;          ///< is_saturated() of the plan
    double requests_per_second = 0;  ///< of what is polled with a period
    double bytes_per_second = 0;     ///< likewise, both ways
    bool takes_turns = false;        ///< several entries share a stream
};

/// Counted requests (docs/specification.md, section 4). A read and a write that the plan causes count as two,
/// also in one entry: by some strategies they are two entries. A write that only commands send does not
/// count.
struct RequestCounts {
    std::size_t grouped = 0;
    std::size_t ungrouped = 0;  ///< with grouping off everywhere
};
[[nodiscard]] RequestCounts request_counts(const model::Line& line, const LinePlan& plan);

/// The saving of one cost against another, in percent: 90 for 1 instead of 10, negative if it is greater.
/// Zero if there was no cost.
struct Saving {
    double requests = 0;
    double bytes = 0;
    double bus_time = 0;
    double cycle = 0;
    double utilization = 0;
    double requests_per_second = 0;
    double bytes_per_second = 0;
};

/// The whole line planned by one strategy, in place of those of its devices.
struct StrategyCost {
    model::Strategy strategy = model::Strategy::single;
    Cost cost;
    Saving saved;  ///< against strategy `single`
};

struct Comparison {
    std::size_t line = 0;                    ///< index into the project's lines
    Cost grouped;                            ///< of the plan given
    Cost single;                             ///< of strategy `single` for every device
    Saving saved;                            ///< by `grouped` against `single`
    std::array<StrategyCost, 3> strategies;  ///< single, classic, optimal

    /// The strategy of the given plan; nothing if its devices have different ones.
    std::optional<model::Strategy> configured;

    /// Some requests alternate: bytes, bus time and cycle are then not comparable.
    [[nodiscard]] bool takes_turns() const;
};

/// Compares a plan with plans of the same project by each strategy. One comparison per line, in order.
/// @param plan  of that project, by any strategy
[[nodiscard]] std::vector<Comparison> compare(const model::Project& project, const Plan& plan);

}  // namespace takt::plan
