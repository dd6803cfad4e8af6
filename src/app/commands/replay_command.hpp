// takt replay (docs/commands).
#pragma once

#include <string>

#include "commands/common_options.hpp"
#include "exit_code.hpp"

namespace takt::app {

struct ReplayOptions {
    std::string file;    ///< the project
    std::string output;  ///< its name
    std::string from;    ///< as of takt history
    bool json = false;
};

ExitCode replay(const CommonOptions& common, const ReplayOptions& options);

}  // namespace takt::app
