// The engine of `takt run` on many TCP devices, measured.
//
// Missed: releases that passed while an earlier one waited. Lateness: from the moment a request is due to the
// moment its bytes are handed to the socket. Processor: user and system time of the master's process. Memory:
// what the heap holds for a line with its device, its request and its connection, beside the project's
// description and the values; what the kernel holds for a socket is not in it. At the end all connections are
// reset at once, and the time until all are there again is taken.
#pragma once

#include <cstdint>
#include <optional>

#include "field.hpp"
#include "takt/base/latency_statistics.hpp"
#include "takt/base/time.hpp"

namespace takt::bench {

struct Scale {
    std::size_t devices = 5000;
    Duration time = std::chrono::seconds(60);
};

struct ScaleMeasured {
    double connected_s = 0;
    double reconnected_s = 0;
    double time_s = 0;
    double processor = 0;  // part of one core
    std::uint64_t sent = 0;
    std::uint64_t answered = 0;
    std::uint64_t missed = 0;
    LatencyStatistics lateness;
    double project_bytes = 0;  // a device, in each
    double value_bytes = 0;
    double poller_bytes = 0;
    double connection_bytes = 0;
};

/// Nothing: not all devices could be connected to.
[[nodiscard]] std::optional<ScaleMeasured> measure_scale(const Scale& scale, Field& field);

}  // namespace takt::bench
