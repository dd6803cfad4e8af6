// A plan, told: as tables, and as the JSON object of the design, section 6.
#pragma once

#include <string>

#include "takt/app/texts.hpp"
#include "takt/file/json.hpp"
#include "takt/plan/plan.hpp"

namespace takt::app {

/// A table of requests for each line, each with the reason why it ends where it ends.
[[nodiscard]] std::string plan_text(const Texts& texts, const model::Project& project,
                                    const plan::Plan& plan);

/// The list "lines". @param compare  each line also has "compare"
[[nodiscard]] file::Json plan_json(const Texts& texts, const model::Project& project, const plan::Plan& plan,
                                   bool compare);

}  // namespace takt::app
