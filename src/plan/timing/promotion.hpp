// Promotion: reading spans more often than needed if that costs less.
#pragma once

#include <cstddef>

#include "timing/timetable.hpp"

namespace takt::plan {

/// Limit of tried timetables for one device and function, without those that move whole periods.
inline constexpr std::size_t kMostTrials = 512;

/// A timetable of low utilization. Starts with the given periods. Unless these divide each other, periods and
/// single spans are also rounded down to multiples of shorter ones. The result never exceeds the cost of
/// separate periods. It exceeds the best partition into blocks of the given periods by less than one per
/// cent, the price of progressions.
/// @param trials  remaining number of tried timetables; counted down
[[nodiscard]] Timetable least_timetable(Neighbourhood& neighbourhood, std::size_t& trials);

}  // namespace takt::plan
