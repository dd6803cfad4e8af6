// takt capture (docs/commands).
#pragma once

#include <optional>
#include <string>

#include "commands/common_options.hpp"
#include "exit_code.hpp"
#include "takt/base/time.hpp"
#include "takt/console/capture_file.hpp"

namespace takt::app {

struct CaptureOptions {
    std::string target;     ///< URL of a serial port; empty: an interface
    std::string interface;  ///< network interface; empty: a serial port
    console::CaptureFileOptions file;
    std::optional<Duration> run_for;  ///< nothing: until stopped
};

/// Records what passes on a serial line or a network interface, and sends nothing.
ExitCode capture(const CommonOptions& common, const CaptureOptions& options);

}  // namespace takt::app
