// How a user ends a command: Ctrl-C, a polite kill, a closed terminal. One rule for all commands:
// - SIGINT and SIGTERM stop, also where the parent process had them ignored. A non-interactive shell starts
//   background jobs with SIGINT ignored; there is no other wish behind it.
// - SIGHUP stops unless it is ignored: nohup asks for that.
#pragma once

#include <functional>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/line/loop.hpp"

namespace takt::app {

/// Gives SIGINT and SIGTERM their default actions back, for all commands. To be called once, when the program
/// starts.
void accept_stop_signals();

/// The signals that stop a command: SIGINT and SIGTERM, and SIGHUP unless it is ignored.
[[nodiscard]] std::vector<int> stop_signals();

/// Calls back on each of stop_signals(). @returns what Loop::on_signals() returns
[[nodiscard]] Result<void> on_stop(line::Loop& loop, std::function<void()> callback);

/// Holds SIGHUP back until on_stop_or_reload(), for a command that reads its files first: the default action
/// would end it. To be called before a thread is started.
void hold_reload();

/// SIGHUP, ignored or not, is the wish to read something again. It stops only a command whose terminal was
/// closed.
[[nodiscard]] Result<void> on_stop_or_reload(line::Loop& loop, std::function<void()> stop,
                                             std::function<void()> reload);

}  // namespace takt::app
