// Looks outside the program: files and commands. These calls may block; see LoopWorker.
#pragma once

#include <string>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/model/source.hpp"
#include "takt/source/loop_worker.hpp"

namespace takt::source {

/// The first bytes of a file, without the line ends behind them. A pipe or a device that has nothing to say
/// is not waited for.
/// @returns cannot_open (path, errno), io_failed (path, errno), too_long (path, kMostText)
Result<std::string> read_small_file(const std::string& path);

/// What a command printed, without the line ends behind it. It runs without a shell, in a process group of
/// its own, with /dev/null as its standard input and error; at the time-out, when `stop` is set, or beyond
/// kMostText bytes the group is killed. Its own processes that it leaves behind are killed too.
/// @returns cannot_open (program, errno), timed_out (program, ms), too_long (program, kMostText),
///          io_failed (program, its exit code, or 128 + the signal that ended it)
Result<std::string> run_command(const model::Command& command, const StopFlag& stop);

/// The command with `value` in the place of each `{value}` in its arguments; not in the program's name.
model::Command with_value(const model::Command& command, const std::string& value);

/// A column of a CSV file as numbers, one a row.
/// Columns are separated by commas, semicolons or tabs (whichever stands in the first row); the first row
/// holds the headings where one of its cells is no number. A column is named by its heading, or by its
/// number from 1.
/// @returns cannot_open (path, errno), too_long (path, kMostReplay), not_found ("path: column"), syntax
///          ("path:line: cell")
Result<std::vector<double>> read_column(const std::string& path, const std::string& column);

inline constexpr std::size_t kMostReplay = 16U << 20;  ///< bytes of a CSV file

}  // namespace takt::source
