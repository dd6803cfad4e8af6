// The requests of one device (requirements, section 4).
#pragma once

#include <vector>

#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

/// Whether a used variable is read, and whether it is written without being told to by a command.
[[nodiscard]] bool is_read(const model::Variable& variable);
[[nodiscard]] bool is_written(const model::Variable& variable, model::Strategy strategy);

/// The entries of a device: those that read by function and start, then those that only write by function and
/// start. Device index, bus time and frame lengths are left to the caller. `strategy` is single or classic.
[[nodiscard]] std::vector<Request> device_requests(const model::Project& project, const model::Line& line,
                                                   const model::Device& device, model::Strategy strategy);

}  // namespace takt::plan
