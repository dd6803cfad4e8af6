// takt scan (docs/commands).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "commands/common_options.hpp"
#include "exit_code.hpp"
#include "takt/base/time.hpp"

namespace takt::app {

struct ScanOptions {
    std::vector<std::string> targets;
    std::string units = "1-247";
    std::string bauds;     ///< empty: the target's, else the usual ones
    std::string parities;  ///< likewise
    std::string stop_bits;
    std::optional<Duration> timeout;  ///< nothing: 100 ms on serial lines, 1 s elsewhere
    bool first = false;               ///< leave a serial port after the first settings that found something
    bool thorough = false;            ///< ask silent units by other functions too
    bool identify = true;
    bool json = false;
    std::string project;  ///< file for a project of what was found; empty: none
    bool force = false;   ///< overwrite it
    std::string traffic;
};

ExitCode scan(const CommonOptions& common, const ScanOptions& options);

}  // namespace takt::app
