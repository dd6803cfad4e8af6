// How punctually devices are polled while an output's broker is dead, slow, hangs, and is back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "../scale/field.hpp"
#include "../working_folder.hpp"

namespace takt::bench {

struct PollingOptions {
    std::size_t devices = 500;
    std::size_t variables = 10;  ///< of each device
    int seconds = 10;            ///< of each phase
};

/// Lateness of a request: from the moment it is due to the moment its bytes go to the socket. The earliest
/// request of a device gives the moments of the others.
struct PhaseMeasured {
    std::string name;
    std::size_t polls = 0;
    std::size_t missed = 0;  ///< periods without a request
    double p50_us = 0;
    double p99_us = 0;
    double most_us = 0;
    double usual_p99_us = 0;  ///< median of the p99 of each second
    double processor = 0;     ///< of this process: part of one core
    // Of the output, samples a second.
    double sampled = 0;
    double delivered = 0;
    std::uint64_t waiting = 0;  ///< samples at the end of the phase
    std::uint64_t dropped = 0;  ///< samples in the whole run
};

using PollingRun = std::vector<PhaseMeasured>;

/// One run of a host through all phases: without outputs; the broker dead, slow, hanging, back with what
/// waited, and without a backlog; without outputs again, which shows how even the machine is. Throws Failure.
[[nodiscard]] PollingRun measure_polling(const PollingOptions& options, const Field& field,
                                         const WorkingFolder& folder);

}  // namespace takt::bench
