// Faults from a seed on a simulated line.
#pragma once

#include <functional>
#include <memory>

#include "faults.hpp"
#include "takt/sim/simulated_line.hpp"

namespace takt::sim {

/// For SimulatedLine::Options::faults.
[[nodiscard]] std::function<std::unique_ptr<LineFaults>(const model::Line&, Devices&)> faults_of(
    FaultPlan plan, FaultObserver* observer = nullptr);

/// Of a line with faults_of().
[[nodiscard]] const FaultCounts& fault_counts(const SimulatedLine& line);

}  // namespace takt::sim
