#include "takt/plan/compare.hpp"

#include "exact_time.hpp"
#include "takt/base/assert.hpp"

namespace takt::plan {
namespace {

Cost cost_of(const model::Line& line, const LinePlan& plan) {
    const Ruler ruler(line);
    ExactTime bus_time = 0;
    Cost cost;
    cost.requests = plan.request_count;
    cost.cycle = plan.cycle;
    for (const Request& request : plan.requests) {
        const model::Device& device = line.devices[request.device];
        for (const auto& function : {request.read, request.write}) {
            if (!function) continue;
            const auto [asked, answered] = frame_lengths(line.framing, *function, request.quantity);
            cost.bytes += asked + answered;
            bus_time += ruler.transaction(device, asked, answered, estimated_turnaround(device));
        }
    }
    cost.bus_time = ruler.rounded_up(bus_time);
    return cost;
}

double percent_saved(double grouped, double single) {
    return single > 0 ? (single - grouped) / single * 100 : 0;
}

double percent_saved(Duration grouped, Duration single) {
    return percent_saved(static_cast<double>(grouped.count()), static_cast<double>(single.count()));
}

Saving saving(const Cost& grouped, const Cost& single) {
    return {percent_saved(static_cast<double>(grouped.requests), static_cast<double>(single.requests)),
            percent_saved(static_cast<double>(grouped.bytes), static_cast<double>(single.bytes)),
            percent_saved(grouped.bus_time, single.bus_time), percent_saved(grouped.cycle, single.cycle)};
}

}  // namespace

std::vector<Comparison> compare(const model::Project& project, const Plan& plan) {
    TAKT_ASSERT(plan.lines.size() == project.lines.size());
    const Plan single = make_plan(project, {.strategy = model::Strategy::single});
    std::vector<Comparison> comparisons;
    for (std::size_t i = 0; i < plan.lines.size(); ++i) {
        const Cost grouped = cost_of(project.lines[i], plan.lines[i]);
        const Cost ungrouped = cost_of(project.lines[i], single.lines[i]);
        comparisons.push_back({i, grouped, ungrouped, saving(grouped, ungrouped)});
    }
    return comparisons;
}

}  // namespace takt::plan
