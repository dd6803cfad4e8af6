// The state of a search as JSON.
#pragma once

#include <string_view>

#include "devices/device_search.hpp"
#include "takt/file/json.hpp"
#include "takt/host/configuration.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::web {

/// Before the name of a polled line, as the target of a search.
inline constexpr std::string_view kLineTarget = "line:";

/// The line of the project with the same port, or the same host and TCP port (as written); nullptr: none.
[[nodiscard]] const model::Line* line_with_endpoint(const model::Project& project, const model::Line& wanted);

/// The object of GET /search. Its devices have the nodes of the project document that they would be, as
/// bus::found_project() makes them.
[[nodiscard]] file::Json search_json(const report::Texts& texts, const DeviceSearch::State& state,
                                     const host::Configuration& configuration);

}  // namespace takt::web
