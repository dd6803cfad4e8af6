#include "cost/request_cost.hpp"

#include "takt/plan/plan.hpp"

namespace takt::plan {
namespace {

constexpr std::uint32_t kAllItems = 65536;
constexpr std::uint32_t kBitsPerByte = 8;

}  // namespace

std::uint32_t RequestCost::items_at_floor() const {
    if (floor < base + step) return 0;
    if (step == 0) return kAllItems;
    const ExactTime units = std::min((floor - base) / step, ExactTime{kAllItems});
    return std::min(static_cast<std::uint32_t>(units) * unit, kAllItems);
}

RequestCost read_cost(const model::Line& line, const model::Device& device, wire::Function function) {
    const BusTimeModel bus_times(line);
    const auto time = [&](std::uint32_t items) {
        const auto [asked, answered] = frame_lengths(line.framing, function, items);
        return bus_times.occupied(device, asked + answered, estimated_turnaround(device),
                                  in_flight(line, device));
    };
    RequestCost cost;
    cost.unit = wire::counts_bits(function) ? kBitsPerByte : 1;
    cost.step = time(2 * cost.unit) - time(cost.unit);
    cost.base = time(cost.unit) - cost.step;
    cost.floor = bus_times.of(line.request_gap) * in_flight(line, device);
    return cost;
}

std::int64_t in_flight(const model::Line& line, const model::Device& device) {
    return line.is_serial() ? 1 : std::max<std::int64_t>(device.in_flight, 1);
}

}  // namespace takt::plan
