// GET /info, /status, /values, /requests, /devices/learnt, /why: the state of the project.
#pragma once

#include <string>
#include <vector>

#include "takt/web/api.hpp"
#include "takt/web/host_access.hpp"

namespace takt::web {

struct ProgramInfo {
    std::string project;
    std::string version;
    bool demo = false;
    bool allow_write = false;
    bool editable = false;
    bool history = false;
};

/// @param host, info  outlive the routes
[[nodiscard]] std::vector<ApiRoute> state_routes(const HostAccess& host, const ProgramInfo& info);

/// Bytes of the body of a command or of a search.
inline constexpr std::size_t kMostCommandBody = 64 << 10;

/// The answer to a body that is not the JSON that the route takes: 400.
[[nodiscard]] ApiResponse malformed_body(const ApiRequest& request);

/// The answer to an error of the host: 503.
[[nodiscard]] ApiResponse host_error(const ApiRequest& request, const Error& error);

/// A copy of the state, through a session that is opened for it.
[[nodiscard]] Result<host::Snapshot> take_snapshot(const HostAccess& host, const host::SnapshotParts& parts);

}  // namespace takt::web
