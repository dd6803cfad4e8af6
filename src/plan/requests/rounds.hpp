// Multi-rate reads: requests for spans with several periods (docs/planning.md, "Several periods").
#pragma once

#include <span>
#include <vector>

#include "timing/promotion.hpp"
#include "timing/timetable.hpp"

namespace takt::plan {

/// Requests of low utilization that read each span at least once per period. Neighbouring spans share
/// requests when several are due, and slow ones may be read more often (promotion.hpp). The utilization never
/// exceeds that of cover() for each period alone. It exceeds that of cover() for everything due at each
/// instant by at most one per cent, if the periods of spans that may share requests stay within the limits of
/// Calendar. Ordered by items, then phase. Deterministic.
/// @param spans  as for cover()
[[nodiscard]] std::vector<TimedWindow> rounds(std::span<const TimedSpan> spans, const CoverRules& rules);

}  // namespace takt::plan
