// Where the time of a line went, and what broke the assumptions of its proof, as text and as JSON.
#pragma once

#include <cstddef>
#include <string>

#include "takt/file/json.hpp"
#include "takt/host/snapshot.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// An indented line for each part that was measured.
[[nodiscard]] std::string line_times_text(const Texts& texts, const poll::LineTimes& times);

/// `wire`, `turnaround`, `host`: each null, or `count`, `p50_us`, `p99_us`, `longest_us` and `histogram`.
[[nodiscard]] file::Json line_times_json(const poll::LineTimes& times);

/// Pairs of the longest time of a bucket in us and its count.
[[nodiscard]] file::Json histogram_json(const poll::HistogramSnapshot& times);

/// An indented line for each request with transactions longer than their C, or with values that became older
/// than their bound; the first ones only where there are many.
/// @param snapshot  with statistics
[[nodiscard]] std::string broken_bounds_text(const Texts& texts, const host::Snapshot& snapshot,
                                             std::size_t line);

}  // namespace takt::report
