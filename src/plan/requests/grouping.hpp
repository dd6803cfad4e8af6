// The requests of one device (docs/specification.md, section 4).
#pragma once

#include <optional>
#include <vector>

#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

/// Whether a used variable is read, and whether it is written on change or by a trigger.
[[nodiscard]] bool is_read(const model::Variable& variable);
[[nodiscard]] bool is_written(const model::Variable& variable, model::Strategy strategy);

/// The time within which a value is due: its deadline, else its period; nothing if that is 0.
[[nodiscard]] std::optional<Duration> due_within(const model::Variable& variable);
/// The lesser of two; nothing means never.
[[nodiscard]] std::optional<Duration> sooner(const std::optional<Duration>& a,
                                             const std::optional<Duration>& b);

/// The requests of a device: those that read, ordered by function and start, then those that only write,
/// likewise. The caller sets device index, bus time and frame lengths. Streams are numbered from 0.
/// `strategy` is single or classic.
[[nodiscard]] std::vector<Request> device_requests(const model::Project& project, const model::Line& line,
                                                   const model::Device& device, model::Strategy strategy);

}  // namespace takt::plan
