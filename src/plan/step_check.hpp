// The pauses by which a master makes sure that a unit is in step (docs/decisions/0039-surplus-responses.md).
#pragma once

#include <functional>

#include "line_tasks.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

/// The units that may have neither two shapes nor a pause in each wire::kStepCheckInterval.
/// @param made  all tasks of the line
[[nodiscard]] std::vector<StepHold> step_holds(const model::Line& line, const LinePlan& plan,
                                               const LineTasks& made);

/// The responses of all tasks, with the holds of the line.
/// @param analyse  response_times(), or one of its variants
[[nodiscard]] Responses responses_with_holds(
    const LineTasks& line, const std::function<Responses(const std::vector<Task>&)>& analyse);

/// The tasks, and each hold as a task of the highest priority.
[[nodiscard]] std::vector<Task> tasks_and_holds(const LineTasks& line);

}  // namespace takt::plan
