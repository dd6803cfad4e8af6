// What grouping saves: a plan beside the same project polled one variable at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// What the requests of one line cost.
struct Cost {
    std::size_t requests = 0;  ///< counted requests (requirements, section 4)
    std::uint64_t bytes = 0;   ///< characters on the line, each read and each write once, both ways
    Duration bus_time{};       ///< of each read and each write once
    Duration cycle{};          ///< of one round of the polled entries alone
};

/// By how much one cost is below another, in percent: 90 for 1 instead of 10. Zero where there was no cost.
struct Saving {
    double requests = 0;
    double bytes = 0;
    double bus_time = 0;
    double cycle = 0;
};

struct Comparison {
    std::size_t line = 0;  ///< index into the project's lines
    Cost grouped;          ///< of the plan given
    Cost single;           ///< of strategy `single` for every device
    Saving saved;          ///< by `grouped` against `single`
};

/// Compares a plan of the project with its plan under strategy `single`; one comparison for each line, in
/// order.
/// @param plan  of the same project, under whatever strategy
[[nodiscard]] std::vector<Comparison> compare(const model::Project& project, const Plan& plan);

}  // namespace takt::plan
