// Files beside a project: what was learnt of its devices, and its retained values.
#pragma once

#include <string>

#include "takt/app/project.hpp"

namespace takt::app {

/// "plant.learnt.json" for "plant.yaml".
[[nodiscard]] std::string learnt_path(const std::string& project_file);

/// Puts what was learnt before into a project whose devices learn, and adds what is wrong with the file to its
/// findings.
/// @returns the file to keep what is learnt; empty when there is a file that cannot be used, or nothing learns
[[nodiscard]] std::string recall_learnt(LoadedProject& loaded, const std::string& project_file);

/// The file of retained values: "plant.state" for "plant.yaml".
[[nodiscard]] std::string default_state_path(const std::string& project_file);

}  // namespace takt::app
