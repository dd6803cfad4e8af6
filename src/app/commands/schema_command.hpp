// takt schema (docs/commands).
#pragma once

#include "commands/common_options.hpp"
#include "exit_code.hpp"

namespace takt::app {

/// Prints the JSON Schema of project files.
ExitCode schema(const CommonOptions& common);

}  // namespace takt::app
