// The counters of servers and gateways: the summary at the end of `takt serve` and of `takt run`.
#pragma once

#include <string>
#include <string_view>

#include "takt/endpoint/statistics.hpp"
#include "takt/model/project.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// One line for each listener, a second one for its connections, one each for refused and ended connections
/// where there are any, one for each unit with retained registers, and one to three for each instrument.
[[nodiscard]] std::string served_text(const Texts& texts, const endpoint::Statistics& statistics);

/// The same as one JSON object and a line end.
/// @param event  value of the key `event`, which comes first in a stream of events; empty: no such key
[[nodiscard]] std::string served_json(const endpoint::Statistics& statistics, std::string_view event = {});

/// The requests relayed to each line: in words, or as JSON objects, a line each.
/// @param project  whose lines the statistics have
[[nodiscard]] std::string relayed_text(const Texts& texts, const model::Project& project,
                                       const endpoint::Statistics& statistics);
[[nodiscard]] std::string relayed_json(const model::Project& project, const endpoint::Statistics& statistics);

}  // namespace takt::report
