// What the strategies cost beside each other, told: as a table, and as JSON.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "takt/file/json.hpp"
#include "takt/plan/compare.hpp"
#include "takt/report/texts.hpp"

namespace takt::report {

/// A table for each line: requests, bytes, bus time, cycle, line busy; with several periods requests and
/// bytes per second instead of those of a round. Below each strategy what it saves against single; a bar
/// shows how busy it keeps the line.
[[nodiscard]] std::string comparison_text(const Texts& texts, const model::Project& project,
                                          const plan::Plan& plan);

/// {"grouped","ungrouped","saved_percent","strategies":{"single":{…},"classic":{…},"optimal":{…}}}
[[nodiscard]] file::Json comparison_json(const plan::Comparison& comparison);

/// The rows of a comparison: single, classic, optimal, and the plan as configured where it is none of these.
struct ComparedRow {
    std::string name;
    std::string_view style;               ///< single, classic, optimal, mixed
    const plan::Cost* cost = nullptr;     ///< of the comparison
    const plan::Saving* saved = nullptr;  ///< nothing for single
    bool configured = false;              ///< these are the requests of the plan
};
[[nodiscard]] std::vector<ComparedRow> compared_rows(const Texts& texts, const plan::Comparison& comparison);

/// "-29 %"
[[nodiscard]] std::string saving_text(double percent);

}  // namespace takt::report
