// Checks a plan independently: whether it reads and writes the whole map, and at what cost.
#pragma once

#include <string>

#include "reference.hpp"
#include "takt/plan/plan.hpp"

namespace corpus {

struct Checked {
    Seconds round = 0;    ///< bus time of each polled request once
    Seconds rate = 0;     ///< seconds of bus time a second
    std::string mistake;  ///< the first that was found; empty: none
};

/// Every value is read whole at least every period, within the limits, by requests that cost what the plan
/// says; every written value is written by exactly one entry, which touches nothing else.
/// @param all_gaps  items that are not requested may be read
[[nodiscard]] Checked check(const Map& map, const Bus& bus, bool all_gaps,
                            const takt::model::Project& project, const takt::plan::LinePlan& plan);

}  // namespace corpus
