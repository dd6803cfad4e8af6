// A plan, told: as tables, and as the JSON object of docs/commands/plan.md.
#pragma once

#include <span>
#include <string>

#include "takt/file/json.hpp"
#include "takt/plan/plan.hpp"
#include "takt/report/guarantee_report.hpp"
#include "takt/report/texts.hpp"

namespace takt::report {

/// A table of requests for each line, each with the reason why it ends where it ends, and beside its bus time
/// what is proved of it.
/// @param guarantees  of each line; may be empty
[[nodiscard]] std::string plan_text(const Texts& texts, const model::Project& project, const plan::Plan& plan,
                                    std::span<const plan::LineGuarantee> guarantees = {});

/// "rs485-1 (rtu, 38400 bit/s): 7 requests instead of 13, …"
[[nodiscard]] std::string line_heading(const Texts& texts, const model::Project& project,
                                       const plan::LinePlan& planned);

/// What causes a request: its period, triggers, changes.
[[nodiscard]] std::string when_text(const Texts& texts, const model::Project& project,
                                    const plan::Request& request);

/// The names of a request's variables; of many the first ones, the last and their number.
[[nodiscard]] std::string variables_text(const model::Device& device, const plan::Request& request);

/// The list "lines". @param proof  of that plan
/// @param compare  each line also has "compare"
[[nodiscard]] file::Json plan_json(const Texts& texts, const model::Project& project, const plan::Plan& plan,
                                   const plan::Proof& proof, bool compare);

}  // namespace takt::report
