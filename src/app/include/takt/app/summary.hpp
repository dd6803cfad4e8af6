// What a run amounted to: planned and measured, for each line, device and request.
#pragma once

#include <string>

#include "takt/app/reporter.hpp"
#include "takt/file/json.hpp"

namespace takt::app {

/// Tables for people: a line's cycle planned and measured, its counters, its devices, its requests.
[[nodiscard]] std::string summary_text(const Scene& scene, const Texts& texts, Instant t);

/// {"event":"summary","duration_ms","lines":[{"name","planned_cycle_ms","measured_cycle_ms","utilization","counters":{…},
///  "devices":[{"name","state","counters"}],"requests":[{…}]}]}
[[nodiscard]] file::Json summary_json(const Scene& scene, Instant t);

}  // namespace takt::app
