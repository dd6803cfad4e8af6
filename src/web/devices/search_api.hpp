// GET /search, GET /search/targets, and POST /search/scan, /search/probe, /search/cancel: finding devices
// from the page.
#pragma once

#include <vector>

#include "devices/device_search.hpp"
#include "takt/web/api.hpp"
#include "takt/web/host_access.hpp"

namespace takt::web {

/// Most requests of one scan to different units: targets x settings x units.
inline constexpr std::size_t kMostVisits = 70'000;

/// @param search, host  outlive the routes
[[nodiscard]] std::vector<ApiRoute> search_routes(DeviceSearch& search, const HostAccess& host);

}  // namespace takt::web
