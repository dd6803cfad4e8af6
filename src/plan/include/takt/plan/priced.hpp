// A plan of given requests.
#pragma once

#include <cstddef>
#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// The plan of a line with these requests, in their order: bus times, frame lengths and load are computed.
/// The requests have device, variables, functions, start, quantity and causes; each names a device and
/// variables of the line, which is one of the project. Allocates; any thread.
[[nodiscard]] LinePlan priced(const model::Project& project, std::size_t line, std::vector<Request> requests);

}  // namespace takt::plan
