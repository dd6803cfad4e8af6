// The gaps that were tried on the devices of a line, as text and as JSON.
#pragma once

#include <string>

#include "takt/file/json.hpp"
#include "takt/model/project.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// A line for each function of each device with `gaps: learn`: its confirmed, refused and untried items.
/// Empty where no device has it.
[[nodiscard]] std::string learnt_text(const Texts& texts, const model::Project& project, std::size_t line);

/// The list "learnt" of `takt plan --json` (docs/commands/plan.md).
[[nodiscard]] file::Json learnt_json(const model::Project& project, std::size_t line);

}  // namespace takt::report
