// What a request of a device costs the line, as a function of the items it asks for.
#pragma once

#include <algorithm>
#include <cstdint>

#include "exact_time.hpp"
#include "takt/model/project.hpp"

namespace takt::plan {

/// Exact cost of a request of n >= 1 items: max(floor, base + step * ceil(n / unit)), all >= 0, unit >= 1.
/// Bus time without request_gap grows by one step with each register, and with each byte of 8 bits; the floor
/// is request_gap.
struct RequestCost {
    ExactTime floor = 0;
    ExactTime base = 0;
    ExactTime step = 0;
    std::uint32_t unit = 1;

    [[nodiscard]] ExactTime operator()(std::uint32_t items) const {
        return std::max(floor, base + step * ((items + unit - 1) / unit));
    }
    /// Most items that still cost no more than the floor; 0: none, 65536: all.
    [[nodiscard]] std::uint32_t items_at_floor() const;
};

/// What reads of that function are to be chosen by: bus time (docs/planning.md, bus time) with the estimated
/// turnaround, in the units of a Ruler of that line. On TCP the requests in flight share the round trip:
/// round_trip / in_flight + frame_gap + 10 ns a byte, at least request_gap; all times are then multiplied by
/// in_flight() to stay whole.
[[nodiscard]] RequestCost read_cost(const model::Line& line, const model::Device& device,
                                    wire::Function function);

/// Requests a device takes before it has answered, as far as the line lets them: 1 on serial lines.
[[nodiscard]] std::int64_t in_flight(const model::Line& line, const model::Device& device);

}  // namespace takt::plan
