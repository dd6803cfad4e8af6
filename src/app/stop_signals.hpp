// How a user ends a command: Ctrl-C, a polite kill, a closed terminal.
#pragma once

#include <functional>

#include "takt/base/result.hpp"
#include "takt/line/loop.hpp"

namespace takt::app {

/// Calls back on SIGINT and SIGTERM, and on SIGHUP unless it is ignored (nohup). @returns what
/// Loop::on_signals() returns
[[nodiscard]] Result<void> on_stop(line::Loop& loop, std::function<void()> callback);

/// SIGHUP, ignored or not, is the wish to read something again. It stops only a command whose terminal was
/// closed.
[[nodiscard]] Result<void> on_stop_or_reload(line::Loop& loop, std::function<void()> stop,
                                             std::function<void()> reload);

}  // namespace takt::app
