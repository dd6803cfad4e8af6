// A project cut down to one line, for planning that line alone.
#pragma once

#include "takt/model/project.hpp"

namespace takt::plan {

/// A project with that line only, at index 0, and with what the plan and the proof of a line need of
/// `project`: its settings and its locals.
[[nodiscard]] model::Project with_one_line(const model::Project& project, model::Line line);

}  // namespace takt::plan
