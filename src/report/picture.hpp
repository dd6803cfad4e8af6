// What the picture of a plan is put together from; each part draws below `top` and says where it ends.
#pragma once

#include <cstddef>

#include "takt/plan/compare.hpp"
#include "takt/plan/timeline.hpp"
#include "takt/report/svg.hpp"
#include "takt/report/texts.hpp"

namespace takt::report::picture {

constexpr double kWidth = 1200;
constexpr double kMargin = 24;
constexpr double kPlotLeft = 200;  ///< left of it stand the names of the rows
constexpr double kPlotWidth = kWidth - kMargin - kPlotLeft;

constexpr double kSmall = 11;  ///< font sizes; the style sheet has the same
constexpr double kBody = 13;

/// What the bars of a page were made of, for its legend.
struct Legend {
    bool pause = false;
    bool late = false;
    bool background = false;  ///< requests without a period
    bool whole = false;       ///< bars too short to show their parts
};

/// A round of one line: all of it, and its beginning enlarged where the bars are too short to read.
/// @return where the next part may begin
double draw_timeline(Svg& svg, const Texts& texts, const model::Project& project, const plan::LinePlan& plan,
                     double top, std::size_t most_bars, Legend& legend);

/// Requests, bus time and load under each strategy as bars.
double draw_comparison(Svg& svg, const Texts& texts, const plan::Comparison& comparison, double top);

}  // namespace takt::report::picture
