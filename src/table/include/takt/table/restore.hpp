// Restores a project and its plan from a request table, as far as the table contains them.
#pragma once

#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/table/owen_view.hpp"
#include "takt/table/view.hpp"

namespace takt::table {

/// The lines, devices, variables and locals of the table, in its order: item i is the slot i of the project.
/// It has all that a poller needs. It has no strategies, ranges, deadlines and faults, which only planning
/// needs, and no comments and source locations. Objects without a name are named by kind and number: `item7`.
[[nodiscard]] model::Project project_of(const View& view);

/// The requests of the plan, without their reasons.
[[nodiscard]] plan::Plan plan_of(const View& view);

/// A project with its plan.
struct Restored {
    model::Project project;
    plan::Plan plan;
};

/// The requests of a table of owen-kc1 and what they are about (expand()). Lines have no port. Lines,
/// devices, locals and values are named by kind and number: `value3` is at place 3. Locals that only the
/// program used are bools.
/// @returns what expand() and View::open() return
[[nodiscard]] Result<Restored> restored(const OwenView& table);

}  // namespace takt::table
