// The response times of a capture as a picture.
#pragma once

#include <string>

#include "takt/report/times/latency_report.hpp"

namespace takt::report {

/// A histogram with logarithmic axes and percentiles, and the course of the times over the capture.
[[nodiscard]] std::string latency_svg(const Texts& texts, const LatencyRun& run);

}  // namespace takt::report
