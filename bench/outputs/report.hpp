// Prints the measurements as text and as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "backlog.hpp"
#include "polling.hpp"

namespace takt::bench {

/// A phase in units of the first one of its run; medians of all runs.
struct PhaseRatio {
    std::string name;
    double p99 = 0;
    double usual_p99 = 0;
};

[[nodiscard]] std::vector<PhaseRatio> ratios_of(const std::vector<PollingRun>& runs);

void print_head(const PollingOptions& options);
void print(const PollingRun& run);
void print(const std::vector<PhaseRatio>& ratios);
[[nodiscard]] nlohmann::json to_json(const PollingRun& run);
[[nodiscard]] nlohmann::json to_json(const std::vector<PhaseRatio>& ratios);

void print_head(const BacklogOptions& options);
void print(const BacklogMeasured& measured);
[[nodiscard]] nlohmann::json to_json(const BacklogMeasured& measured);

}  // namespace takt::bench
