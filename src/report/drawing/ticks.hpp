// Round positions for the labels of an axis.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "takt/store/history_reader.hpp"

namespace takt::report {

/// Multiples of 1, 2 or 5 times a power of ten, from `least` to `greatest`.
/// @param most  at most so many and one
[[nodiscard]] std::vector<double> value_ticks(double least, double greatest, std::size_t most);

struct TimeTick {
    std::int64_t time_ns = 0;
    std::string text;  ///< local; with the date where it is another one than before
};

/// Full seconds, minutes, hours or days of local time in a range.
/// @param most  at most so many and one
[[nodiscard]] std::vector<TimeTick> time_ticks(const store::HistoryRange& range, std::size_t most);

}  // namespace takt::report
