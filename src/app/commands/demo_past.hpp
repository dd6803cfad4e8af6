// The past of the demo's plant, for its trends.
#pragma once

#include <string>

#include "commands/demo_plant.hpp"
#include "takt/base/result.hpp"
#include "takt/model/project.hpp"

namespace takt::app {

/// Writes the hour before `now` to a new history: what a master would have read from the simulated devices of
/// the line at those instants. Variables that the plant does not have are left out.
/// @param plant  as it is now
/// @returns the errors of store::History
[[nodiscard]] Result<void> write_demo_past(const std::string& database, const model::Line& line,
                                           DemoPlant& plant, Instant now);

}  // namespace takt::app
