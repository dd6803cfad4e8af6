// One run of the simulation: the gateway between its lines, its disk, its brokers and its clocks.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "complaints.hpp"
#include "takt/base/time.hpp"

namespace takt::gatewaysim {

struct Settings {
    std::uint64_t seed = 1;
    Duration length = std::chrono::minutes(3);
    bool trace = false;
};

struct RunResult {
    std::uint64_t seed = 0;
    std::uint64_t hash = 0;
    std::map<std::string, std::uint64_t> counts;
    std::vector<Violation> violations;
};

/// Runs until the end or the first violation.
[[nodiscard]] RunResult run(const Settings& settings);

}  // namespace takt::gatewaysim
