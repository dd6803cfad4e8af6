// The parts of the picture of a plan. Each draws below `top` and returns the coordinate of its end.
#pragma once

#include <cstddef>

#include "takt/plan/compare.hpp"
#include "takt/plan/timeline.hpp"
#include "takt/report/drawing/svg.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report::picture {

constexpr double kWidth = 1200;
constexpr double kMargin = 24;
constexpr double kPlotLeft = 250;  ///< the names of the rows are left of it
constexpr double kPlotWidth = kWidth - kMargin - kPlotLeft;

constexpr double kSmall = 11;  ///< font sizes; the style sheet has the same
constexpr double kBody = 13;

/// The kinds of bars that a page has, for its legend.
struct Legend {
    bool pause = false;
    bool late = false;
    bool background = false;  ///< requests without a period
    bool whole = false;       ///< bars too short to show their parts
};

/// A round of one line, and its beginning enlarged where the bars are too short to read.
/// @return the y coordinate below the part
double draw_timeline(Svg& svg, const Texts& texts, const model::Project& project, const plan::LinePlan& plan,
                     double top, std::size_t most_bars, Legend& legend);

/// Requests, bus time and load under each strategy as bars.
double draw_comparison(Svg& svg, const Texts& texts, const plan::Comparison& comparison, double top);

}  // namespace takt::report::picture
