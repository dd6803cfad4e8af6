// The requests that read spans with several periods (docs/guarantees.md; specification, section 3).
#pragma once

#include <span>
#include <vector>

#include "promotion.hpp"
#include "timetable.hpp"

namespace takt::plan {

/// Requests of low utilization that read each span at instants never more than its period apart: spans near
/// each other share requests where several are due, and slow ones may be read more often (promotion.hpp).
/// Never above the utilization of cover() for each period alone, and at most one per cent above that of
/// cover() for all that is due at each instant, where the periods of spans that may share requests keep to
/// the limits of Calendar. By items, then phase. Deterministic.
/// @param spans  as for cover()
[[nodiscard]] std::vector<TimedWindow> rounds(std::span<const TimedSpan> spans, const CoverRules& rules);

}  // namespace takt::plan
