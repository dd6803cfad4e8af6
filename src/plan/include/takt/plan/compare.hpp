// What a strategy saves: a plan beside the same project planned by each strategy.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// What the requests of one line cost. With several periods it is the figures per second that compare: an
/// entry that is one of several taking turns (Request::stream) is sent more rarely than what it stands for.
struct Cost {
    std::size_t requests = 0;        ///< counted requests (specification, section 4)
    std::uint64_t bytes = 0;         ///< characters on the line, each read and each write once, both ways
    Duration bus_time{};             ///< of each read and each write once
    Duration cycle{};                ///< of one round of the polled entries alone
    double utilization = 0;          ///< sum of bus time / period of what is polled with a period
    double requests_per_second = 0;  ///< of what is polled with a period
    double bytes_per_second = 0;     ///< likewise, both ways
    bool takes_turns = false;        ///< several entries share a stream
};

/// By how much one cost is below another, in percent: 90 for 1 instead of 10, negative where it is above.
/// Zero where there was no cost.
struct Saving {
    double requests = 0;
    double bytes = 0;
    double bus_time = 0;
    double cycle = 0;
    double utilization = 0;
    double requests_per_second = 0;
    double bytes_per_second = 0;
};

/// The whole line planned by one strategy, whatever its devices ask for.
struct StrategyCost {
    model::Strategy strategy = model::Strategy::single;
    Cost cost;
    Saving saved;  ///< against strategy `single`
};

struct Comparison {
    std::size_t line = 0;                    ///< index into the project's lines
    Cost grouped;                            ///< of the plan given
    Cost single;                             ///< of strategy `single` for every device
    Saving saved;                            ///< by `grouped` against `single`
    std::array<StrategyCost, 3> strategies;  ///< single, classic, optimal

    /// The strategy whose requests the plan given has; nothing where its devices differ in strategy.
    std::optional<model::Strategy> configured;

    /// Some of what is compared takes turns: bytes, bus time and cycle of "each once" do not compare.
    [[nodiscard]] bool takes_turns() const;
};

/// Compares a plan of the project with its plans by each strategy; one comparison for each line, in order.
/// @param plan  of the same project, under whatever strategy
[[nodiscard]] std::vector<Comparison> compare(const model::Project& project, const Plan& plan);

}  // namespace takt::plan
