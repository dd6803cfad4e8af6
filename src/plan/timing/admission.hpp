// Rate limits and deadlines of requests.
#pragma once

#include <optional>

#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

/// The rate limit of a trigger.
[[nodiscard]] std::optional<model::RateLimit> trigger_admission(
    const model::Project& project, const std::optional<model::LocalIndex>& trigger);

/// The rate limit of the writes of one variable: that of its start-writing trigger, else its own for writes
/// on change.
[[nodiscard]] std::optional<model::RateLimit> write_admission(const model::Project& project,
                                                              const model::Variable& variable);

/// The rate limit of a request: that of its writes, the lowest rate of its members; for a read, that of its
/// start-reading trigger.
[[nodiscard]] std::optional<model::RateLimit> admission_of(const model::Project& project,
                                                           const model::Device& device,
                                                           const Request& request);

/// The least deadline of its variables; nothing: none has one.
[[nodiscard]] std::optional<Duration> least_deadline(const model::Device& device, const Request& request);

/// The deadline of a request: the least explicit one of its variables, else its period, else the least
/// interval between two commands. Nothing: none of these, or as fast as the line allows.
[[nodiscard]] std::optional<Duration> deadline_of(const model::Device& device, const Request& request);

}  // namespace takt::plan
