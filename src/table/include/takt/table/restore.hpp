// Restores a project and its plan from a request table, as far as the table contains them.
#pragma once

#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/table/view.hpp"

namespace takt::table {

/// The lines, devices, variables and locals of the table, in its order: item i is the slot i of the project.
/// It has all that a poller needs. It has no strategies, ranges, deadlines and faults, which only planning
/// needs, and no comments and source locations. Objects without a name are named by kind and number: `item7`.
[[nodiscard]] model::Project project_of(const View& view);

/// The requests of the plan, without their reasons.
[[nodiscard]] plan::Plan plan_of(const View& view);

}  // namespace takt::table
