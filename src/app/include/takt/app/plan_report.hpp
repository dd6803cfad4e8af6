// A plan, told: as tables, and as the JSON object of the design, section 6.
#pragma once

#include <span>
#include <string>

#include "takt/app/guarantee_report.hpp"
#include "takt/app/texts.hpp"
#include "takt/file/json.hpp"
#include "takt/plan/plan.hpp"

namespace takt::app {

/// A table of requests for each line, each with the reason why it ends where it ends, and beside its bus time
/// what is proved of it.
/// @param guarantees  of each line; may be empty
[[nodiscard]] std::string plan_text(const Texts& texts, const model::Project& project, const plan::Plan& plan,
                                    std::span<const plan::LineGuarantee> guarantees = {});

/// The list "lines". @param proof  of that plan
/// @param compare  each line also has "compare"
[[nodiscard]] file::Json plan_json(const Texts& texts, const model::Project& project, const plan::Plan& plan,
                                   const Proof& proof, bool compare);

}  // namespace takt::app
