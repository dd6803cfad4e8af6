// The pauses by which a master makes sure that a unit is in step (docs/decisions/0039-surplus-responses.md).
#pragma once

#include <functional>

#include "proof/line_tasks.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

/// The reads of each unit. Empty on TCP, whose responses have numbers.
/// @param made  all tasks of the line
[[nodiscard]] std::vector<StepHold> step_holds(const model::Line& line, const LinePlan& plan,
                                               const LineTasks& made);

/// The responses of all tasks. A unit is held only if its reads, with these responses, may fill a whole
/// wire::kStepCheckInterval without a pause and with responses of one shape.
/// @param analyse  response_times(), or one of its variants
[[nodiscard]] Responses responses_with_holds(
    const LineTasks& line, const std::function<Responses(const std::vector<Task>&)>& analyse);

/// The tasks, and as a task of the highest priority each hold that is needed if all deadlines are met.
[[nodiscard]] std::vector<Task> tasks_and_holds(const LineTasks& line);

/// For the tests: whether each of line.holds is needed with these responses.
[[nodiscard]] std::vector<bool> holds_needed(const LineTasks& line, const Responses& responses);

}  // namespace takt::plan
