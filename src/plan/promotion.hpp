// Reading spans more often than asked, where that costs less.
#pragma once

#include <cstddef>

#include "timetable.hpp"

namespace takt::plan {

/// Most timetables of a few spans that are tried for one device and function, besides those of whole periods.
inline constexpr std::size_t kMostTrials = 512;

/// A timetable of low utilization: with all periods as they are, and, unless these divide each other, with
/// periods and single spans rounded down to multiples of shorter ones. Never above each period alone; above
/// the best partition into blocks of the spans' own periods by less than one per cent, the price of turns.
/// @param trials  how many more may be tried; counted down
[[nodiscard]] Timetable least_timetable(Neighbourhood& neighbourhood, std::size_t& trials);

}  // namespace takt::plan
