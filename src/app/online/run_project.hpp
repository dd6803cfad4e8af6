// Running a checked project from begin to summary: what `run` and `demo` have in common.
#pragma once

#include <cstddef>
#include <functional>

#include "commands.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/sim/devices.hpp"
#include "texts.hpp"

namespace takt::app {

/// Prepares the devices of the simulated line `line` before it starts.
using PrepareDevices = std::function<void(std::size_t line, sim::Devices& devices)>;

/// @param prepare  may be empty
ExitCode run_project(const Texts& texts, const model::Project& project, const plan::Plan& plan,
                     const RunOptions& options, const PrepareDevices& prepare = {});

}  // namespace takt::app
