// The cost of a request as a function of its number of items.
#pragma once

#include <algorithm>
#include <cstdint>

#include "cost/exact_time.hpp"
#include "takt/model/project.hpp"

namespace takt::plan {

/// The exact cost of a request of n >= 1 items: max(floor, base + step * ceil(n / unit)), all >= 0, unit >=
/// 1. Without request_gap the bus time grows by one step per register, or per byte of 8 bits. The floor is
/// request_gap.
struct RequestCost {
    ExactTime floor = 0;
    ExactTime base = 0;
    ExactTime step = 0;
    std::uint32_t unit = 1;

    [[nodiscard]] ExactTime operator()(std::uint32_t items) const {
        return std::max(floor, base + step * ((items + unit - 1) / unit));
    }
    /// The greatest number of items at the floor; 0: none, 65536: all.
    [[nodiscard]] std::uint32_t items_at_floor() const;
};

/// The cost function of reads with that function: bus time (docs/planning.md, "Bus time") with the estimated
/// turnaround, in the units of the line's BusTimeModel. On TCP requests in flight share the round trip:
/// round_trip / in_flight + frame_gap + 10 ns a byte, at least request_gap. All times are multiplied by
/// in_flight() to stay integers.
[[nodiscard]] RequestCost read_cost(const model::Line& line, const model::Device& device,
                                    wire::Function function);

/// Requests in flight of a device, as far as the line allows: 1 on serial lines.
[[nodiscard]] std::int64_t in_flight(const model::Line& line, const model::Device& device);

}  // namespace takt::plan
