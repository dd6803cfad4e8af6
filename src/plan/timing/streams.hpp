// Streams: requests of a line that alternate, and the phases between streams.
#pragma once

#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// Whether the request is polled with a period above zero. Such requests form streams.
[[nodiscard]] inline bool is_periodic(const Request& request) {
    return request.read && request.period > Duration::zero();
}

/// Numbers the streams in the order of their first requests. Polled requests with a period that have a
/// variable in common belong to one stream (transitively). Each request gets the least deadline of the
/// variables of its stream; a variable without one counts with its period.
/// @param requests  of one line, with device, variables and period
void number_streams(const model::Line& line, std::vector<Request>& requests);

/// Shifts whole streams so that little bus time is due at the same instant. Greedy: the stream with the
/// longest request first, each one by the multiple of the shortest period among the variables of `movable`
/// devices at which the rounds are emptiest so far. Instants beyond kMostInstants are ignored. All phases
/// stay below the periods.
/// @param requests  of one line, with streams and bus times, all phases from one start
/// @param movable  for each device of the line, whether its streams may be shifted
void spread(const model::Line& line, const std::vector<bool>& movable, std::vector<Request>& requests);

}  // namespace takt::plan
