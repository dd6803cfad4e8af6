// From a request table back to a project and its plan, as far as they are in it.
#pragma once

#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/table/view.hpp"

namespace takt::table {

/// The lines, devices, variables and locals of the table, in its order: item i is the slot i of the project.
/// Everything a poller looks at, without what is only planned with (strategies, ranges, deadlines, faults)
/// and without comments and places. What has no name is called by its kind and number: `item7`.
[[nodiscard]] model::Project project_of(const View& view);

/// The requests as they were planned, without their reasons.
[[nodiscard]] plan::Plan plan_of(const View& view);

}  // namespace takt::table
