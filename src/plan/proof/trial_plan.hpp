// Plans of a search, most of which are discarded.
#pragma once

#include <cstddef>
#include <optional>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// Plans one line as plan_line() does. Returns nothing as soon as the devices so far surely exceed the line:
/// then the proof of that plan has a polled request without a bound, so the line is not feasible.
/// @param planned  grows by the number of variables that were planned
[[nodiscard]] std::optional<LinePlan> trial_plan(const model::Project& project, std::size_t line,
                                                 std::size_t& planned);

}  // namespace takt::plan
