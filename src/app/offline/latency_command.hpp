// The two sources of takt latency, and its output.
#pragma once

#include <string>

#include "commands.hpp"
#include "takt/report/times/latency_report.hpp"
#include "texts.hpp"

namespace takt::app {

/// A target has a scheme; anything else is a file.
[[nodiscard]] inline bool is_target(const std::string& source) {
    return source.find("://") != std::string::npos;
}

/// latency() of a target.
ExitCode latency_of_target(const Texts& texts, const LatencyOptions& options);

/// Prints the report in the form that the options ask for, and writes the picture.
ExitCode print_latency(const Texts& texts, const LatencyOptions& options, const report::LatencyRun& run);

}  // namespace takt::app
