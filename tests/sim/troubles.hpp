// Adapters and faults that a seed puts between the master and its devices.
#pragma once

#include "takt/sim/simulated_line.hpp"
#include "world.hpp"

namespace takt::simtest {

/// The adapter between the master and a serial line.
struct Adapter {
    bool echoes = false;    ///< the master receives its own bytes
    std::size_t chunk = 0;  ///< characters that come together; 0: a whole transmission
};

[[nodiscard]] Adapter adapter_of(const model::Line& line, std::uint64_t seed, std::size_t index);

/// @param quiet_from  no fault begins after it
[[nodiscard]] sim::FaultPlan fault_plan(const model::Project& project, const Run& settings, std::size_t line,
                                        Instant quiet_from);

}  // namespace takt::simtest
