// The request queue of a controller is limited (docs/specification.md, section 2).
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "takt/model/findings.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

/// Size of the queue of profile owen-kc1, in counted requests.
inline constexpr std::size_t kOwenQueue = 1024;

struct QueueLimit {
    /// A warning `plan.too_many_requests` (count, limit, name) at the first variable of each device that
    /// loses requests.
    std::vector<model::Finding> findings;
    std::optional<Plan> plan;  ///< of what is left of a project of profile owen-kc1
};

/// Removes the requests beyond kOwenQueue from a checked project of profile owen-kc1, counted in the order of
/// device address, then of the file: their variables are no longer read or written without a command. Other
/// projects, and those that fit, are unchanged.
[[nodiscard]] QueueLimit keep_to_queue(model::Project& project);

}  // namespace takt::plan
