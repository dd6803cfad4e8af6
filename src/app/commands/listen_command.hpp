// takt listen (docs/commands).
#pragma once

#include <optional>
#include <string>

#include "commands/common_options.hpp"
#include "exit_code.hpp"
#include "takt/base/time.hpp"

namespace takt::app {

struct ListenOptions {
    std::string port;  ///< device file, serial target or capture
    std::string project;
    std::string write;  ///< file for the project of what was heard
    bool force = false;
    std::optional<Duration> run_for;
    Duration timeout = std::chrono::seconds(1);
    bool quiet = false;
    bool json = false;
};

ExitCode listen(const CommonOptions& common, const ListenOptions& options);

}  // namespace takt::app
