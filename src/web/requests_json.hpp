// GET /requests: the requests of the plans that run, with their counters.
#pragma once

#include "takt/file/json.hpp"
#include "takt/host/snapshot.hpp"

namespace takt::web {

/// @param snapshot  with statistics, times and plan
[[nodiscard]] file::Json requests_json(const host::Snapshot& snapshot);

}  // namespace takt::web
