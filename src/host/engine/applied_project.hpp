// The pending call of ProjectHost::apply().
#pragma once

#include <memory>
#include <optional>
#include <semaphore>

#include "engine/project_engine.hpp"

namespace takt::host {

/// Shared by the thread that applies a project and the I/O thread.
struct AppliedProject {
    bool done = false;
    std::optional<Error> error;               ///< its servers could not be opened
    std::unique_ptr<ProjectEngine> replaced;  ///< to be destroyed off the I/O thread
    std::binary_semaphore ready{0};
};

}  // namespace takt::host
