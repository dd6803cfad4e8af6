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
    std::string units;     ///< empty: all
    std::string bauds;     ///< empty: the target's, else the usual ones
    std::string parities;  ///< likewise
    std::string stop_bits;
    std::optional<Duration> timeout;  ///< nothing: as of discover::ScanRequest
    bool first = false;               ///< leave a serial port after the first settings that found something
    bool thorough = false;            ///< ask silent units by other functions too
    bool identify = true;
    bool json = false;
    bool probe = false;   ///< find the registers of each device for the project
    std::string project;  ///< file for a project of what was found; empty: none
    bool force = false;   ///< overwrite it
    std::string traffic;
};

ExitCode scan(const CommonOptions& common, const ScanOptions& options);

}  // namespace takt::app
