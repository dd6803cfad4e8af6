// A million samples that wait, delivered by `takt run` while new ones arrive.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "../scale/field.hpp"
#include "../working_folder.hpp"

namespace takt::bench {

struct BacklogOptions {
    std::string program;  ///< takt
    std::size_t samples = 1'000'000;
    std::size_t devices = 500;
    std::size_t variables = 2;  ///< of each device: with the devices, new samples a second
};

struct BacklogMeasured {
    double plain_per_s = 0;       ///< messages a second of a client that only publishes
    double takt_per_s = 0;        ///< samples a second, until all that waited were delivered
    double seconds = 0;           ///< for them
    std::uint64_t at_start = 0;   ///< samples that waited
    std::uint64_t at_end = 0;     ///< samples in all
    std::uint64_t delivered = 0;  ///< received by the subscriber without a hole
    std::uint64_t repeated = 0;
    std::uint64_t out_of_order = 0;
    std::uint64_t waiting = 0;  ///< at the end
    std::uint64_t dropped = 0;
    std::uint64_t peak_kib = 0;  ///< memory of the program: VmHWM
    double processor = 0;        ///< of the program: part of one core

    /// Everything came in order, and nothing is missing.
    [[nodiscard]] bool is_complete() const {
        return out_of_order == 0 && dropped == 0 && delivered + waiting == at_end && at_end > at_start;
    }
};

/// Throws Failure.
[[nodiscard]] BacklogMeasured measure_backlog(const BacklogOptions& options, const Field& field,
                                              const WorkingFolder& folder);

}  // namespace takt::bench
