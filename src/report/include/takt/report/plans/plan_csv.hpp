// The requests of a plan as a table.
#pragma once

#include <string>

#include "takt/file/json.hpp"

namespace takt::report {

/// A row for each request of each line, with a heading row. The columns are `line` and the keys of the
/// requests of `takt plan --json` (docs/commands/plan.md). The items of a list are separated by "; ".
/// @param plan  of project_plan_json() or applied_json()
[[nodiscard]] std::string plan_csv(const file::Json& plan);

}  // namespace takt::report
