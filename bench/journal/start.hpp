// The start with a journal that has many bytes of waiting records.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "../working_folder.hpp"

namespace takt::bench {

struct StartMeasured {
    std::uint64_t bytes = 0;  ///< of the segments
    std::size_t segments = 0;
    std::uint64_t waiting = 0;  ///< samples
    double fill = 0;            ///< seconds
    std::vector<double> cold;   ///< seconds of a Journal::open(), nothing of the segments is cached
    std::vector<double> warm;   ///< the segments' beginnings and the last segment are cached
};

/// Writes a journal of `bytes` (or of what the disk has, less a reserve) that nothing is delivered of, and
/// opens it `runs` times. Throws Failure.
[[nodiscard]] StartMeasured measure_start(std::uint64_t bytes, int runs, const WorkingFolder& folder);

}  // namespace takt::bench
