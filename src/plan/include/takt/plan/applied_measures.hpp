// A project with the measures that change nothing but its plan.
#pragma once

#include <cstddef>
#include <vector>

#include "takt/plan/proof.hpp"

namespace takt::plan {

struct AppliedMeasures {
    model::Project project;               ///< changed
    std::vector<Change> changes;          ///< each key once
    std::vector<std::size_t> not_helped;  ///< infeasible lines without such a measure
    Proof proof;                          ///< of the changed project, without measures
};

/// Applies to each line the first of its measures that changes only the plan. Deadlines, periods and the bus
/// stay as the user wrote them.
/// @param proof          of the project, with measures
/// @param late_is_error  as in prove()
[[nodiscard]] AppliedMeasures apply_measures(const model::Project& project, const Proof& proof,
                                             bool late_is_error);

}  // namespace takt::plan
