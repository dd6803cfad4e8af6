// The summary at the end of a run: the statistics of each line, device and request.
#pragma once

#include <string>

#include "takt/file/json.hpp"
#include "takt/host/snapshot.hpp"
#include "takt/report/texts.hpp"

namespace takt::report {

/// For each line its cycle and utilization, a table of devices and a table of requests.
/// @param snapshot  with statistics
[[nodiscard]] std::string summary_text(const Texts& texts, const host::Snapshot& snapshot);

/// {"event":"summary", …}
[[nodiscard]] file::Json summary_json(const host::Snapshot& snapshot);

}  // namespace takt::report
