// takt run and takt demo (docs/commands).
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "commands/common_options.hpp"
#include "commands/realtime_mode.hpp"
#include "exit_code.hpp"
#include "takt/base/network.hpp"
#include "takt/base/time.hpp"
#include "takt/console/capture_file.hpp"
#include "takt/line/target.hpp"

namespace takt::app {

/// The page and the API of a run.
struct WebOptions {
    std::optional<line::ListenAddress> address;  ///< nothing: they are not served
    bool or_free_port = false;                   ///< another port if that of `address` is in use
    bool allow_write = false;
    std::string token_file;          ///< empty: no token
    std::vector<std::string> names;  ///< further ones of this machine: web::WebServerOptions::names
    std::vector<Network> proxies;    ///< whose fields X-Forwarded-* count
    bool demo = false;
};

struct RunOptions {
    std::string file;
    bool create = false;              ///< the file, as an empty project; it must not exist
    std::string table;                ///< a request table instead of a project file
    std::string target;               ///< with a table of one line: another serial port, or host:port
    std::optional<Duration> run_for;  ///< nothing: until stopped
    bool json = false;
    std::string traffic;                  ///< file for the frames; "-": stderr; empty: none
    console::CaptureFileOptions capture;  ///< empty path: none
    bool commands_from_stdin = false;
    std::string control_path;  ///< Unix socket for commands; empty: none
    bool learn = true;         ///< devices with gaps: learn are tried
    std::string learnt;        ///< the file that keeps it; empty: none
    bool quiet = false;        ///< no values: changes of state only
    std::string device;        ///< values and events of this device only; empty: all
    std::string state;         ///< file of retained values; empty: beside the project (of the demo: none)
    RealtimeMode realtime;
    WebOptions web;
    /// Called if the process ends inside the run (leave_program()). May be empty.
    std::function<void()> on_leave = {};
};

struct DemoOptions {
    std::optional<Duration> run_for;
    bool json = false;
    bool web = true;  ///< serve the page
};

ExitCode run(const CommonOptions& common, const RunOptions& options);
ExitCode demo(const CommonOptions& common, const DemoOptions& options);

}  // namespace takt::app
