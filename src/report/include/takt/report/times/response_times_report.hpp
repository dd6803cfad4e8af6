// The measured response times of a device, as text and as JSON.
#pragma once

#include <string>

#include "takt/file/json.hpp"
#include "takt/model/project.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// One line each, without its end: the turnaround, where the project does not write it, and late responses.
/// Empty where nothing was measured.
[[nodiscard]] std::string turnaround_text(const Texts& texts, const model::Device& device,
                                          const model::MeasuredTimes& measured);
[[nodiscard]] std::string late_responses_text(const Texts& texts, const model::Device& device,
                                              const model::MeasuredTimes& measured);
/// Both, indented and with their ends.
[[nodiscard]] std::string response_times_text(const Texts& texts, const model::Device& device,
                                              const model::MeasuredTimes& measured);

/// Objects (docs/commands/run.md, "Response times"); null where nothing was measured.
[[nodiscard]] file::Json turnaround_json(const model::Device& device, const model::MeasuredTimes& measured);
[[nodiscard]] file::Json late_responses_json(const model::MeasuredTimes& measured);

/// Of each device of the project of which something is known from earlier runs.
[[nodiscard]] std::string learnt_times_text(const Texts& texts, const model::Line& line);
/// A list; `device`, `unit`, `turnaround`, `late_responses`.
[[nodiscard]] file::Json learnt_times_json(const model::Line& line);
/// The same of all lines; each entry begins with `line`.
[[nodiscard]] file::Json learnt_times_json(const model::Project& project);

}  // namespace takt::report
