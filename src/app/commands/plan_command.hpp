// takt plan (docs/commands).
#pragma once

#include <string>

#include "commands/common_options.hpp"
#include "exit_code.hpp"

namespace takt::app {

struct PlanOptions {
    std::string file;
    bool json = false;
    bool csv = false;
    bool compare = false;
    std::string svg;  ///< file for the picture; "-": stdout instead of the text; empty: none
    bool no_notes = false;
    bool prove = false;  ///< as for CheckOptions
    bool fix = false;    ///< plan again with the settings that change only the plan
};

ExitCode plan(const CommonOptions& common, const PlanOptions& options);

}  // namespace takt::app
