// Guarantees as text and JSON: bounds, verdict, measures.
#pragma once

#include <string>
#include <vector>

#include "takt/file/json.hpp"
#include "takt/plan/guarantee_findings.hpp"
#include "takt/plan/proof.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// Adds c_us, f_us, response_us, …: microseconds, rounded up; null where there is no bound.
void set_bound(file::Json& request, const plan::Bound& bound);
/// The greatest age of each variable of a request, in microseconds; null: unbounded.
[[nodiscard]] file::Json ages_json(const plan::LineGuarantee& guarantee, const plan::Request& request);
/// The worst load of a line and its verdict.
/// @param unknown  plan::unknown_turnarounds(): the load is not shown, unless it is proved with time-outs
[[nodiscard]] std::string guarantee_text(const Texts& texts, const plan::LineGuarantee& line,
                                         plan::Verdict verdict, const std::string& unknown);

/// The measures for each infeasible line, with their effect and the keys to write into the project file.
[[nodiscard]] std::string measures_text(const Texts& texts, const model::Project& project,
                                        const plan::Proof& proof);
[[nodiscard]] file::Json measures_json(const Texts& texts, const std::vector<plan::Measure>& measures,
                                       std::size_t line);
[[nodiscard]] std::string changes_text(const Texts& texts, const std::vector<plan::Change>& changes);
[[nodiscard]] file::Json changes_json(const std::vector<plan::Change>& changes);

}  // namespace takt::report
