// takt selftest (docs/commands).
#pragma once

#include "commands/common_options.hpp"
#include "commands/realtime_mode.hpp"
#include "exit_code.hpp"
#include "takt/base/time.hpp"

namespace takt::app {

struct SelftestOptions {
    Duration time = std::chrono::seconds(5);  ///< of each measurement
    RealtimeMode realtime;
    bool json = false;
};

/// Measures what this computer adds to an exchange, idle and under load.
ExitCode selftest(const CommonOptions& common, const SelftestOptions& options);

}  // namespace takt::app
