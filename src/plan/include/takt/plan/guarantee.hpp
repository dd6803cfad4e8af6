// What is proved about a plan: the longest response of each request, the greatest age of each value, and what
// would make them hold (guarantees; requirements, section 10).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// Of one request, each rounded up to whole microseconds. Nothing: there is no bound.
struct Bound {
    Duration transaction{};                       ///< C, with the proved turnaround
    Duration failure{};                           ///< F
    std::optional<Duration> response;             ///< R
    std::optional<Duration> response_with_fault;  ///< R under the project's faults
    std::optional<Duration> response_with_dead;   ///< R with the worst single dead device
    std::optional<Duration> deadline;             ///< D
    std::optional<Duration> age;                  ///< T + R, the greatest among its values
};

struct LineGuarantee {
    std::size_t line = 0;
    std::vector<Bound> requests;  ///< in the order of the plan's requests
    double utilization = 0;       ///< with C
    /// All polled values, and all commands behind an admission, hold their deadlines without failures.
    bool feasible = true;
    bool feasible_edf = true;  ///< second opinion: earliest deadline first
};

/// The guarantees of each line, in order.
[[nodiscard]] std::vector<LineGuarantee> guarantee(const model::Project& project, const Plan& plan);

}  // namespace takt::plan
