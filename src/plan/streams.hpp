// Entries of a line that take turns, and how their instants lie to each other.
#pragma once

#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// Numbers the streams in the order of their first requests: polled requests with a period that name the same
/// variable share one, and with them all that do with one of these. Each of them gets the least deadline of
/// the variables of its stream; a variable's own is its period where it has no other.
/// @param requests  of one line, with device, variables and period
void number_streams(const model::Line& line, std::vector<Request>& requests);

/// Shifts whole streams such that little bus time is due at once: by multiples of the shortest period among
/// the variables of `movable` devices, the stream with the longest request first, each to where the rounds
/// are emptiest so far. What lies beyond kMostInstants is not looked at. All phases stay below the periods.
/// @param requests  of one line, with streams and bus times, all phases from one start
/// @param movable  for each device of the line whether its streams may be shifted
void spread(const model::Line& line, const std::vector<bool>& movable, std::vector<Request>& requests);

}  // namespace takt::plan
