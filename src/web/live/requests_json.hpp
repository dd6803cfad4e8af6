// The requests of plans: with their counters, for GET /requests, and their course, for evaluations.
#pragma once

#include "takt/file/json.hpp"
#include "takt/host/snapshot.hpp"
#include "takt/model/line.hpp"
#include "takt/plan/plan.hpp"

namespace takt::web {

/// @param snapshot  with statistics, times and plan
[[nodiscard]] file::Json requests_json(const host::Snapshot& snapshot);

/// The course of a line's polling, as plan::timeline() has it: {"length_ms", "bars"}; a bar is [request,
/// start_us, end_us, whether it is late].
[[nodiscard]] file::Json course_json(const model::Line& line, const plan::LinePlan& planned);

}  // namespace takt::web
