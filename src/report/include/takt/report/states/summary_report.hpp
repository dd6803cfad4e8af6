// The summary at the end of a run: the statistics of each line, device and request.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "takt/file/json.hpp"
#include "takt/host/snapshot.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// For each line its cycle and utilization, a table of devices and a table of requests. A table that is wider
/// than `columns` has its failures below the rows, not in columns; then words are cut.
/// @param snapshot  with statistics
/// @param columns   of the terminal
[[nodiscard]] std::string summary_text(const Texts& texts, const host::Snapshot& snapshot,
                                       std::size_t columns = SIZE_MAX);

/// {"event":"summary", …}
[[nodiscard]] file::Json summary_json(const host::Snapshot& snapshot);

}  // namespace takt::report
