// The history of variables as a picture.
#pragma once

#include <string>
#include <vector>

#include "takt/report/times/history_report.hpp"

namespace takt::report {

/// The pixels that history_svg() draws; what its views are queried with.
inline constexpr std::size_t kHistorySvgPixels = 1000;

/// An SVG document, readable on light and dark pages: each variable below the other, as steps, because a
/// polled value holds. Missing samples, a device that does not answer, and other bad values have hatches of
/// their own. Behind a change lies the band of its age: it happened between the poll before and this one.
[[nodiscard]] std::string history_svg(const Texts& texts, const std::string& title,
                                      const std::vector<HistoryView>& views);

}  // namespace takt::report
