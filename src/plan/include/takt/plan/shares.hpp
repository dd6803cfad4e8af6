// The share of a line's time that each request and each device takes.
#pragma once

#include <cstddef>
#include <vector>

#include "takt/plan/plan.hpp"

namespace takt::plan {

/// Shares of the time of one line by its polling, estimated as Request::bus_time is; 0.5 is half of the time.
/// Requests with period 0 divide the time that the others leave, in the ratio of their bus times.
struct Shares {
    std::vector<double> requests;  ///< in the order of the plan's requests; 0: not polled
    std::vector<double> devices;   ///< in the order of the line's devices
};
[[nodiscard]] Shares shares(const model::Line& line, const LinePlan& plan);

/// A polled request, or the requests of one stream together.
struct StreamShare {
    std::size_t device = 0;
    std::vector<std::size_t> variables;  ///< ascending
    double share = 0;
};

/// The streams with a period, the one with the greatest share first; at most that many.
[[nodiscard]] std::vector<StreamShare> largest_shares(const LinePlan& plan, std::size_t most);

/// A request with period 0 is polled: then the line is never idle.
[[nodiscard]] bool is_saturated(const LinePlan& plan);

/// The share of the line's time that polling takes: LinePlan::utilization, at least 1 if it is saturated.
[[nodiscard]] double busy(const LinePlan& plan);

}  // namespace takt::plan
