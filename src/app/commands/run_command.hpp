// takt run and takt demo (docs/commands).
#pragma once

#include <optional>
#include <string>

#include "commands/common_options.hpp"
#include "exit_code.hpp"
#include "takt/base/time.hpp"

namespace takt::app {

struct RunOptions {
    std::string file;
    std::string table;                ///< a request table instead of a project file
    std::string target;               ///< with a table of one line: another serial port, or host:port
    std::optional<Duration> run_for;  ///< nothing: until stopped
    bool json = false;
    std::string traffic;  ///< file for the frames; "-": stderr; empty: none
    bool commands_from_stdin = false;
    std::string control_path;  ///< Unix socket for commands; empty: none
    bool learn = true;         ///< devices with gaps: learn are tried
    std::string learnt;        ///< the file that keeps it; empty: none
    bool quiet = false;        ///< no values: changes of state only
    std::string device;        ///< values and events of this device only; empty: all
    std::string state;         ///< file of retained values; empty: beside the project (of the demo: none)
};

struct DemoOptions {
    std::optional<Duration> run_for;
    bool json = false;
};

ExitCode run(const CommonOptions& common, const RunOptions& options);
ExitCode demo(const CommonOptions& common, const DemoOptions& options);

}  // namespace takt::app
