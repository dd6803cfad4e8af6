// What `takt read --watch` reads, as a project.
#pragma once

#include "takt/app/client_commands.hpp"
#include "takt/base/result.hpp"
#include "takt/model/project.hpp"

namespace takt::app {

/// A project of that one device, its variables in the order in which they were named.
/// @returns out_of_range, too_long; what line::parse_target() returns
[[nodiscard]] Result<model::Project> watch_project(const ReadOptions& options);

}  // namespace takt::app
