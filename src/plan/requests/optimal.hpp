// Strategy optimal: requests of a device with the least bus time.
#pragma once

#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// The requests of a device: those that read, ordered by function and start, then those that only write,
/// likewise. The caller sets device index, bus time, frame lengths and streams.
///
/// Every used variable that is read is polled with its period. A variable with a start-reading trigger is
/// also read by that trigger's request. This is the polled request itself if it has the same items and
/// variables.
[[nodiscard]] std::vector<Request> optimal_requests(const model::Project& project, const model::Line& line,
                                                    const model::Device& device);

}  // namespace takt::plan
