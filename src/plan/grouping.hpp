// The requests of one device (specification, section 4).
#pragma once

#include <optional>
#include <vector>

#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

/// Whether a used variable is read, and whether it is written without being told to by a command.
[[nodiscard]] bool is_read(const model::Variable& variable);
[[nodiscard]] bool is_written(const model::Variable& variable, model::Strategy strategy);

/// Within what time a value is due: its deadline, else its period; nothing where that is 0.
[[nodiscard]] std::optional<Duration> due_within(const model::Variable& variable);
/// The less of two, where nothing is never.
[[nodiscard]] std::optional<Duration> sooner(const std::optional<Duration>& a,
                                             const std::optional<Duration>& b);

/// The entries of a device: those that read by function and start, then those that only write by function and
/// start. Device index, bus time and frame lengths are left to the caller, streams
/// are numbered from 0. `strategy` is single or classic.
[[nodiscard]] std::vector<Request> device_requests(const model::Project& project, const model::Line& line,
                                                   const model::Device& device, model::Strategy strategy);

}  // namespace takt::plan
