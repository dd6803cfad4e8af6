// takt check (docs/commands).
#pragma once

#include <string>

#include "commands/common_options.hpp"
#include "exit_code.hpp"

namespace takt::app {

struct CheckOptions {
    std::string file;
    bool json = false;
    bool no_notes = false;
    bool firmware = false;  ///< the file describes a microcontroller
    bool prove = false;     ///< late values are errors, also where a turnaround is not known
};

ExitCode check(const CommonOptions& common, const CheckOptions& options);

}  // namespace takt::app
