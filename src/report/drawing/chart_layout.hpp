// The layout that the charts of histories and of response times share, in pixels.
#pragma once

#include <cstddef>

namespace takt::report {

inline constexpr double kChartMargin = 24;
inline constexpr double kChartLeft = 90;  ///< the labels of values are left of it
inline constexpr double kTickFontSize = 11;
inline constexpr std::size_t kMostTimeTicks = 6;

}  // namespace takt::report
