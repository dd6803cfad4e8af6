// takt latency (docs/commands).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "commands/common_options.hpp"
#include "exit_code.hpp"
#include "takt/capture/latency.hpp"
#include "takt/wire/frame.hpp"

namespace takt::app {

struct LatencyOptions {
    std::string capture;                         ///< file; "-": standard input
    std::string interface;                       ///< to listen on, instead of a capture; empty: none
    wire::Framing framing = wire::Framing::tcp;  ///< of the messages in TCP connections
    std::vector<std::uint16_t> ports;            ///< of servers; empty: 502
    Duration timeout = std::chrono::seconds(1);
    std::optional<Duration> limit;
    capture::Grouping grouping;
    bool json = false;
    bool csv = false;
    std::string svg;              ///< file for the picture; "-": stdout
    std::uint32_t histogram = 0;  ///< microseconds; 0: not printed
};

ExitCode latency(const CommonOptions& common, const LatencyOptions& options);

}  // namespace takt::app
