// What was learnt of the devices of a line, as text and as JSON, and news of it.
#pragma once

#include <string>

#include "takt/file/json.hpp"
#include "takt/model/project.hpp"
#include "takt/poll/gap_event.hpp"
#include "takt/report/texts.hpp"

namespace takt::report {

/// A line for each function of each device that learns: what is confirmed, refused, and to be tried. Empty
/// where nothing learns.
[[nodiscard]] std::string learnt_text(const Texts& texts, const model::Project& project, std::size_t line);

/// The list `learnt` of docs/commands/plan.md.
[[nodiscard]] file::Json learnt_json(const model::Project& project, std::size_t line);

/// One lesson in words.
[[nodiscard]] std::string lesson_text(const Texts& texts, const model::Line& line,
                                      const poll::GapEvent& lesson);

}  // namespace takt::report
