// The queue of a controller holds so many requests (specification, section 2).
#pragma once

#include <cstddef>
#include <vector>

#include "takt/model/findings.hpp"
#include "takt/model/project.hpp"

namespace takt::plan {

/// Counted requests the queue of the profile owen-kc1 holds.
inline constexpr std::size_t kOwenQueue = 1024;

/// Leaves out of a checked project of profile owen-kc1 what its requests have beyond kOwenQueue, counted in
/// the order of the devices' addresses, then of the file: variables lose what would have been read or written
/// without being commanded. Other projects, and those that fit, stay as they are.
/// @returns a warning `plan.too_many_requests` (count, limit, name) at the first variable of each device that
///          loses requests
[[nodiscard]] std::vector<model::Finding> keep_to_queue(model::Project& project);

}  // namespace takt::plan
