// The commands of the program. Each function adds some of them, with their options, to the command line.
#pragma once

#include <string>
#include <vector>

#include "commands.hpp"
#include "options/command_line.hpp"

namespace takt::app {

void add_project_commands(CommandLine& line, const CommonOptions& common);  ///< check, plan
void add_convert(CommandLine& line, const CommonOptions& common);
void add_running_commands(CommandLine& line, const CommonOptions& common);  ///< demo, run, ctl
void add_serve(CommandLine& line, const CommonOptions& common);
void add_table_commands(CommandLine& line, const CommonOptions& common);
void add_history(CommandLine& line, const CommonOptions& common);
void add_capture_command(CommandLine& line, const CommonOptions& common);
void add_latency(CommandLine& line, const CommonOptions& common);
void add_listen(CommandLine& line, const CommonOptions& common);
void add_replay(CommandLine& line, const CommonOptions& common);
void add_schema(CommandLine& line, const CommonOptions& common);
void add_selftest(CommandLine& line, const CommonOptions& common);
void add_client_commands(CommandLine& line, const CommonOptions& common);   ///< read, write, raw
void add_finding_commands(CommandLine& line, const CommonOptions& common);  ///< scan, probe

/// The arguments behind the program's name. `--watch` may stand alone: it gets its interval from what follows
/// only where that can be one.
std::vector<std::string> with_intervals(int argc, char** argv);

}  // namespace takt::app
