// The cost of a line under each strategy, as a table and as JSON.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "takt/file/json.hpp"
#include "takt/plan/compare.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// A table for each line: requests, bytes, bus time, cycle, line busy. With several periods it has requests
/// and bytes per second instead of those of a round. Below each strategy is its saving against `single`; a
/// bar shows how busy the line is.
/// @param columns  of the terminal; the bars are shorter where rows would not fit
[[nodiscard]] std::string comparison_text(const Texts& texts, const model::Project& project,
                                          const plan::Plan& plan, std::size_t columns = SIZE_MAX);

/// {"grouped","ungrouped","saved_percent","strategies":{"single":{…},"classic":{…},"optimal":{…}}}
[[nodiscard]] file::Json comparison_json(const plan::Comparison& comparison);

/// A row of a comparison: single, classic, optimal, and the plan itself where its devices differ in strategy.
struct ComparedRow {
    std::string name;
    std::string_view style;               ///< single, classic, optimal, mixed
    const plan::Cost* cost = nullptr;     ///< of the comparison
    const plan::Saving* saved = nullptr;  ///< nullptr for single
    bool configured = false;              ///< these are the requests of the plan
};
[[nodiscard]] std::vector<ComparedRow> compared_rows(const Texts& texts, const plan::Comparison& comparison);

/// "12.3", "250": a rate, with a decimal below 100.
[[nodiscard]] std::string per_second_text(double rate);

/// "-29 %"
[[nodiscard]] std::string saving_text(double percent);

}  // namespace takt::report
