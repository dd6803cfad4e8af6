// The commands as CLI11 sees them: each file adds some of them, and reads their options into CommandLine.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common_options.hpp"

namespace takt::app {

/// All that was asked for. One of the commands is `chosen`; it looks at its own options.
struct CommandLine {
    CommonOptions common;
    CheckOptions check;
    ConvertOptions convert;
    PlanOptions plan;
    RunOptions run;
    DemoOptions demo;
    ServeOptions serve;
    ReadOptions read;
    WriteOptions write;
    RawOptions raw;
    ScanOptions scan;
    ProbeOptions probe;
    TableBuildOptions table_build;
    TableShowOptions table_show;
    CtlOptions ctl;
    std::function<ExitCode()> chosen;
};

/// A command that runs `execute` when it is chosen.
CLI::App& add_command(CLI::App& app, CommandLine& line, const std::string& name, const std::string& help,
                      std::function<ExitCode()> execute);

void add_project_commands(CLI::App& app, CommandLine& line);  ///< check, plan
void add_convert(CLI::App& app, CommandLine& line);
void add_running_commands(CLI::App& app, CommandLine& line);  ///< demo, run, ctl
void add_serve(CLI::App& app, CommandLine& line);
void add_table_commands(CLI::App& app, CommandLine& line);
void add_client_commands(CLI::App& app, CommandLine& line);   ///< read, write, raw
void add_finding_commands(CLI::App& app, CommandLine& line);  ///< scan, probe

/// The arguments behind the program's name. `--watch` may stand alone: it gets its interval from what follows
/// only where that can be one.
std::vector<std::string> with_intervals(int argc, char** argv);

}  // namespace takt::app
