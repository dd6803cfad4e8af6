// A plan as a picture: for each line a round in time, and below it the cost under each strategy.
#pragma once

#include <string>

#include "takt/plan/plan.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// An SVG document. Devices are rows; each request is a bar in which silence, request, turnaround and
/// response differ in colour. At most 40 lines, 64 devices of a line and 2000 requests of a line are drawn;
/// the picture states how many are omitted.
/// @param name  the project's file, for the title
[[nodiscard]] std::string plan_svg(const Texts& texts, const std::string& name, const model::Project& project,
                                   const plan::Plan& plan);

}  // namespace takt::report
