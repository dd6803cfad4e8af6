// Reads files and runs commands. These calls may block; see Worker.
#pragma once

#include <string>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/endpoint/loop_worker.hpp"
#include "takt/model/source.hpp"

namespace takt::endpoint {

/// The beginning of a file without trailing line ends. A pipe or device without data is not waited for.
/// @returns cannot_open (path, errno), io_failed (path, errno), too_long (path, kMostText)
Result<std::string> read_small_file(const std::string& path);

/// The output of a command without trailing line ends. It runs without a shell, in its own process group,
/// with /dev/null as standard input and error. The group is killed at the time-out, when `stop` is set,
/// beyond kMostText bytes, and at the end, so that no process stays behind.
/// @returns cannot_open (program, errno), timed_out (program, ms), too_long (program, kMostText),
///          io_failed (program, its exit code, or 128 + the signal that ended it)
Result<std::string> run_command(const model::Command& command, const StopFlag& stop);

/// The command with `value` instead of each `{value}` in its arguments; the program's name stays.
model::Command with_value(const model::Command& command, const std::string& value);

/// A column of a CSV file as numbers, one per row.
/// The separator is the comma, semicolon or tab of the first row. The first row is a heading if one of its
/// cells is no number. A column is named by its heading, or by its number from 1.
/// @returns cannot_open (path, errno), too_long (path, kMostReplay), not_found ("path: column"), syntax
///          ("path:line: cell")
Result<std::vector<double>> read_column(const std::string& path, const std::string& column);

inline constexpr std::size_t kMostReplay = 16U << 20;  ///< bytes of a CSV file

}  // namespace takt::endpoint
