// How often and how urgently a request may be asked for.
#pragma once

#include <optional>

#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

/// Of a trigger.
[[nodiscard]] std::optional<model::Admission> trigger_admission(
    const model::Project& project, const std::optional<model::LocalIndex>& trigger);

/// Of the writes of one variable: its start-writing trigger's, else its own where it is written on change.
[[nodiscard]] std::optional<model::Admission> write_admission(const model::Project& project,
                                                              const model::Variable& variable);

/// Of a request: that of its writes, the rarest where its members differ; where it only reads, its
/// start-reading trigger's.
[[nodiscard]] std::optional<model::Admission> admission_of(const model::Project& project,
                                                           const model::Device& device,
                                                           const Request& request);

/// The least explicit deadline of its variables; else the period it is polled with, else the least time
/// between two commands. Nothing: none of these, or as fast as the line allows.
[[nodiscard]] std::optional<Duration> deadline_of(const model::Device& device, const Request& request);

}  // namespace takt::plan
