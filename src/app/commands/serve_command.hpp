// takt serve (docs/commands).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "commands/common_options.hpp"
#include "commands/realtime_mode.hpp"
#include "exit_code.hpp"
#include "takt/base/time.hpp"
#include "takt/console/capture_file.hpp"
#include "takt/endpoint/overrides.hpp"
#include "takt/sim/answer_faults.hpp"
#include "takt/sim/fill.hpp"

namespace takt::app {

struct ServeOptions {
    std::string file;    ///< a project whose devices to be; empty: a blank device
    std::string listen;  ///< host:port
    std::string port;    ///< serial port or serial target
    UnitId unit{1};      ///< of the blank device
    sim::Fill fill = sim::Fill::zero;
    bool strict = false;  ///< RTU: pauses above t1.5 inside a frame spoil it
    std::optional<Duration> run_for;
    std::string traffic;
    console::CaptureFileOptions capture;  ///< empty path: none
    bool json = false;                    ///< the summary at the end as one object
    endpoint::LimitOverrides limits;
    std::string access;  ///< file of access rules for all endpoints; empty: those of the project
    std::string audit;   ///< file of writes and refusals at all endpoints; empty: those of the project
    std::vector<sim::FaultRule> faults;
    std::string control_path;  ///< Unix socket for commands to the devices; empty: none
    bool commands_from_stdin = false;
    RealtimeMode realtime;
    std::string line;  ///< the devices of this line of the project alone; empty: of all lines
};

ExitCode serve(const CommonOptions& common, const ServeOptions& options);

}  // namespace takt::app
