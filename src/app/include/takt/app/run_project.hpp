// Running a checked project from begin to summary: what `run` and `demo` have in common.
#pragma once

#include "takt/app/run_command.hpp"
#include "takt/app/running.hpp"
#include "takt/app/texts.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"

namespace takt::app {

/// @param prepare  called for the devices of each simulated line before it starts, with the line's index; may
/// be empty
ExitCode run_project(const Texts& texts, const model::Project& project, const plan::Plan& plan,
                     const RunOptions& options, const Running::Prepare& prepare = {});

}  // namespace takt::app
