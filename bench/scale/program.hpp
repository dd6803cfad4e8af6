// `takt run` with the field's devices for its project, as a process of its own.
#pragma once

#include <cstdint>
#include <expected>
#include <string>

#include "takt/base/time.hpp"

namespace takt::bench {

struct ProgramMeasured {
    double processor = 0;  ///< part of one core, planning and starting included
    double seconds = 0;
    std::uint64_t sent = 0;
    std::uint64_t answered = 0;
    std::uint64_t missed = 0;
    std::uint64_t overruns = 0;
    std::uint64_t peak_kib = 0;
};

/// Runs `program` for `time` with a line and a request a second to each of the devices on `port`.
/// @returns the figures; or why there are none, with the program's messages
std::expected<ProgramMeasured, std::string> run_program(const std::string& program, std::size_t devices,
                                                        Duration time, std::uint16_t port, int processor);

}  // namespace takt::bench
