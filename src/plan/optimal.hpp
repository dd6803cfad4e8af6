// Strategy optimal: the requests of a device with the least bus time.
#pragma once

#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// The entries of a device: those that read by function and start, then those that only write by function and
/// start. Device index, bus time, frame lengths and streams are left to the caller.
///
/// All used variables that are read are polled with their period; those with a start-reading trigger are read
/// by entries of that trigger as well, which are one with a polled entry where that has the same items and
/// variables.
[[nodiscard]] std::vector<Request> optimal_requests(const model::Project& project, const model::Line& line,
                                                    const model::Device& device);

}  // namespace takt::plan
