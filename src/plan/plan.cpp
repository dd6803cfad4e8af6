#include "takt/plan/plan.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "exact_time.hpp"
#include "grouping.hpp"

namespace takt::plan {
namespace {

using model::Strategy;

Strategy strategy_of(const model::Device& device, const Options& options) {
    const Strategy wanted = options.strategy.value_or(device.strategy);
    return wanted == Strategy::optimal ? Strategy::classic : wanted;
}

std::vector<std::size_t> by_address(const std::vector<model::Device>& devices) {
    std::vector<std::size_t> order(devices.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&devices](std::size_t a, std::size_t b) {
        return std::pair(devices[a].address, a) < std::pair(devices[b].address, b);
    });
    return order;
}

std::size_t ungrouped_count(const model::Device& device) {
    std::size_t count = 0;
    for (const model::Variable& v : device.variables) {
        const bool read = is_read(v);
        if (read || is_written(v, Strategy::single)) count += read && v.read_trigger ? 2U : 1U;
    }
    return count;
}

// Adds requests to a line's plan and sums their costs without rounding in between.
class LinePlanner {
public:
    LinePlanner(const model::Line& line, std::size_t index) : line_(line), ruler_(line) {
        plan_.line = index;
    }

    void add(Request request, std::size_t device);
    void count_ungrouped(const model::Device& device) { plan_.ungrouped_requests += ungrouped_count(device); }
    [[nodiscard]] LinePlan finish() &&;

private:
    const model::Line& line_;
    Ruler ruler_;
    LinePlan plan_;
    ExactTime cycle_ = 0;
};

void LinePlanner::add(Request request, std::size_t device) {
    const model::Device& asked = line_.devices[device];
    const auto [request_bytes, response_bytes] =
        frame_lengths(line_.framing, request.read ? *request.read : *request.write, request.quantity);
    const ExactTime time =
        ruler_.transaction(asked, request_bytes, response_bytes, estimated_turnaround(asked));
    request.device = device;
    request.request_bytes = request_bytes;
    request.response_bytes = response_bytes;
    request.bus_time = ruler_.rounded_up(time);
    if (request.period) {
        cycle_ += time;
        if (*request.period > Duration::zero())
            plan_.utilization += static_cast<double>(time) / static_cast<double>(ruler_.of(*request.period));
    }
    plan_.request_count += request.count();
    plan_.requests.push_back(std::move(request));
}

LinePlan LinePlanner::finish() && {
    plan_.cycle = ruler_.rounded_up(cycle_);
    return std::move(plan_);
}

LinePlan plan_line(const model::Project& project, std::size_t index, const Options& options) {
    const model::Line& line = project.lines[index];
    LinePlanner planner(line, index);
    for (const std::size_t device : by_address(line.devices)) {
        const model::Device& asked = line.devices[device];
        for (Request& request : device_requests(project, line, asked, strategy_of(asked, options)))
            planner.add(std::move(request), device);
        planner.count_ungrouped(asked);
    }
    return std::move(planner).finish();
}

}  // namespace

Plan make_plan(const model::Project& project, const Options& options) {
    Plan plan;
    plan.lines.reserve(project.lines.size());
    for (std::size_t i = 0; i < project.lines.size(); ++i)
        plan.lines.push_back(plan_line(project, i, options));
    return plan;
}

}  // namespace takt::plan
