// takt ctl (docs/commands).
#pragma once

#include <string>
#include <vector>

#include "commands/common_options.hpp"
#include "exit_code.hpp"

namespace takt::app {

struct CtlOptions {
    std::string path;
    std::vector<std::string> words;
    bool json = false;  ///< print the answer as JSON
};

ExitCode ctl(const CommonOptions& common, const CtlOptions& options);

}  // namespace takt::app
