// POST /commands, /commands/preview, /devices/probe.
#pragma once

#include <atomic>
#include <vector>

#include "takt/web/api.hpp"
#include "takt/web/host_access.hpp"

namespace takt::web {

/// A command is given to the host in a session of its own. Its answer is the outcome, or `unknown` if the
/// server stops before.
/// @param host, stopping  outlive the routes
[[nodiscard]] std::vector<ApiRoute> command_routes(const HostAccess& host, const std::atomic<bool>& stopping);

}  // namespace takt::web
