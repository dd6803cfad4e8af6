// What endpoints report, as text: notices while they work, and the summary at the end.
#pragma once

#include <string>

#include "takt/console/messages.hpp"
#include "takt/endpoint/notice.hpp"
#include "takt/endpoint/statistics.hpp"
#include "takt/model/project.hpp"
#include "takt/report/serve_report.hpp"
#include "takt/report/texts.hpp"

namespace takt::console {

using report::Texts;

/// Gives the text of a notice to the messages: a warning as an error, anything else as status.
void put_notice(const Texts& texts, const Messages& messages, const endpoint::Notice& notice);

/// What the endpoints counted, for the report at the end.
[[nodiscard]] report::ServeSummary summary_of(const endpoint::Statistics& statistics);

/// What was relayed to each line of a project: in words, or as JSON objects, a line each.
[[nodiscard]] std::string relayed_text(const Texts& texts, const model::Project& project,
                                       const endpoint::Statistics& statistics);
[[nodiscard]] std::string relayed_json(const model::Project& project, const endpoint::Statistics& statistics);

}  // namespace takt::console
