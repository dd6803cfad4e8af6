// takt latency (docs/commands).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "commands/common_options.hpp"
#include "commands/realtime_mode.hpp"
#include "exit_code.hpp"
#include "takt/capture/latency.hpp"
#include "takt/client/load.hpp"
#include "takt/report/latency_report.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/function.hpp"
#include "texts.hpp"

namespace takt::app {

/// How a target is measured. Nothing: not given.
struct LatencyLoad {
    std::optional<wire::Area> area;
    std::optional<std::uint32_t> start;
    std::optional<std::uint32_t> quantity;
    std::optional<std::uint32_t> unit;
    std::optional<std::uint32_t> connections;
    std::optional<std::uint32_t> in_flight;
    std::optional<client::Rate> rate;
    std::optional<Duration> run_for;
    std::optional<std::uint32_t> requests;
    bool same_content = false;
    RealtimeMode realtime;
};

struct LatencyOptions {
    std::string source;     ///< URL of a target, or the file of a capture; "-": standard input
    std::string interface;  ///< to listen on, instead of a source; empty: none
    /// Of the messages in captured TCP connections; nothing: found.
    std::optional<wire::Framing> framing;
    std::vector<std::uint16_t> ports;           ///< of servers in a capture; empty: 502
    std::optional<capture::Grouping> grouping;  ///< of a capture; nothing: all parts
    Duration timeout = std::chrono::seconds(1);
    std::optional<Duration> limit;
    bool json = false;
    bool csv = false;
    std::string svg;              ///< file for the picture; "-": stdout
    std::uint32_t histogram = 0;  ///< microseconds; 0: not printed
    LatencyLoad load;             ///< of a target
};

/// A target has a scheme; anything else is a file.
[[nodiscard]] inline bool is_target(const std::string& source) {
    return source.find("://") != std::string::npos;
}

ExitCode latency(const CommonOptions& common, const LatencyOptions& options);
/// latency() of a target.
ExitCode latency_of_target(const Texts& texts, const LatencyOptions& options);

/// Prints the report in the form that the options ask for, and writes the picture.
ExitCode print_latency(const Texts& texts, const LatencyOptions& options, const report::LatencyRun& run);

}  // namespace takt::app
