// A plan with its proof.
#pragma once

#include <optional>
#include <vector>

#include "takt/model/findings.hpp"
#include "takt/plan/guarantee.hpp"
#include "takt/plan/measures.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

struct Proof {
    Plan plan;
    std::vector<LineGuarantee> lines;      ///< one for each line of the plan
    std::vector<model::Finding> findings;  ///< of guarantee_findings()
    MeasureSearch measures;                ///< of measures(), where they were asked for

    [[nodiscard]] bool has_errors() const;
};

/// Stores the proved ages in the plan (LinePlan::ages, Request::refresh_bound), of the lines that hold their
/// deadlines.
void put_ages(Plan& plan, const std::vector<LineGuarantee>& lines);

/// Stores the proved Request::refresh_bound of a line that holds its deadlines.
void put_refresh_bounds(LinePlan& line, const LineGuarantee& proved);

/// Plans the project and proves its guarantees. The plan has the proved ages.
/// @param late_is_error  late values are errors even where a turnaround is unknown, as in
/// guarantee_findings()
/// @param with_measures  also compute what would make an infeasible line feasible (slow)
/// @param progress       called after each line that is planned, proved or searched, and each trial plan
/// @param planned        the plan of the project, if it was made already
[[nodiscard]] Proof prove(const model::Project& project, bool late_is_error, bool with_measures,
                          const Progress& progress = {}, std::optional<Plan> planned = {});

}  // namespace takt::plan
