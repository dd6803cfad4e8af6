// POST /commands, /commands/preview, /devices/probe.
#pragma once

#include <atomic>
#include <string>
#include <string_view>
#include <vector>

#include "takt/web/api.hpp"
#include "takt/web/host_access.hpp"

namespace takt::web {

class EventLog;

/// A command is given to the host in a session of its own. Its answer is the outcome, or `unknown` if the
/// server stops before.
/// @param host, log, stopping  outlive the routes
[[nodiscard]] std::vector<ApiRoute> command_routes(const HostAccess& host, EventLog& log,
                                                   const std::atomic<bool>& stopping);

/// "done", "waiting", "refused", "unknown" or "expired".
[[nodiscard]] std::string_view outcome_word(const host::Outcome& outcome);
/// The outcome of a `set` or `write` for people.
[[nodiscard]] std::string outcome_text(const report::Texts& texts, const host::Configuration& configuration,
                                       const host::Outcome& outcome);

}  // namespace takt::web
