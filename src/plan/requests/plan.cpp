#include "takt/plan/plan.hpp"
#include "takt/plan/priced.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <tuple>
#include <utility>

#include "cost/exact_time.hpp"
#include "cost/polling_load.hpp"
#include "cost/request_cost.hpp"
#include "proof/trial_plan.hpp"
#include "requests/grouping.hpp"
#include "requests/optimal.hpp"
#include "requests/write_pass.hpp"
#include "takt/base/assert.hpp"
#include "timing/admission.hpp"
#include "timing/streams.hpp"

namespace takt::plan {
namespace {

using model::Strategy;

Strategy strategy_of(const model::Device& device, const Options& options) {
    return options.strategy.value_or(device.strategy);
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

// If a device can write single bits of a register, the bits that classic leaves out get entries of their own.
std::vector<Request> with_bit_writes(const model::Project& project, const model::Device& device,
                                     Strategy strategy, std::vector<Request> requests) {
    if (strategy == Strategy::single) {
        for (Request& request : requests) settle_bit_write(request, device);
        return requests;
    }
    auto bits = bit_write_requests(project, device);
    if (bits.empty()) return requests;
    std::move(bits.begin(), bits.end(), std::back_inserter(requests));
    const auto writing =
        std::find_if(requests.begin(), requests.end(), [](const Request& request) { return !request.read; });
    std::stable_sort(writing, requests.end(), [](const Request& a, const Request& b) {
        return std::tie(*a.write, a.start) < std::tie(*b.write, b.start);
    });
    return requests;
}

// Adds requests to a line's plan. Costs are summed exactly and rounded once.
class LinePlanner {
public:
    LinePlanner(const model::Project& project, std::size_t index)
        : project_(project), line_(project.lines[index]), bus_times_(line_) {
        plan_.line = index;
    }

    /// All requests of a device.
    void add(std::vector<Request> requests, std::size_t device);
    void count_ungrouped(const model::Device& device) { plan_.ungrouped_requests += ungrouped_count(device); }
    [[nodiscard]] std::span<const Request> requests() const { return plan_.requests; }
    /// @param movable  for each device whether its requests may be shifted
    [[nodiscard]] LinePlan finish(const std::vector<bool>& movable) &&;

private:
    void add(Request&& request, std::size_t device);
    /// Of a request on the line, as a share of it.
    [[nodiscard]] double busy_time(const model::Device& device, ExactTime time,
                                   std::size_t transactions) const;

    const model::Project& project_;
    const model::Line& line_;
    BusTimeModel bus_times_;
    LinePlan plan_;
    std::vector<ExactTime> times_;  // of each request
};

void LinePlanner::add(std::vector<Request> requests, std::size_t device) {
    for (Request& request : requests) add(std::move(request), device);
}

// Requests in flight share the time of a transaction, but not request_gap.
double LinePlanner::busy_time(const model::Device& device, ExactTime time, std::size_t transactions) const {
    const auto gaps =
        static_cast<double>(bus_times_.of(line_.request_gap)) * static_cast<double>(transactions);
    return std::max(static_cast<double>(time) / static_cast<double>(in_flight(line_, device)), gaps);
}

void LinePlanner::add(Request&& request, std::size_t device) {
    const model::Device& asked = line_.devices[device];
    const Transactions transactions = main_transactions(line_.framing, request);
    const ExactTime time = bus_times_.sum(asked, transactions, estimated_turnaround(asked));
    request.device = device;
    if (!request.admission) request.admission = admission_of(project_, asked, request);
    if (!request.deadline) request.deadline = deadline_of(asked, request);
    request.request_bytes = request.response_bytes = 0;
    for (const auto& [request_bytes, response_bytes] : transactions) {
        request.request_bytes += request_bytes;
        request.response_bytes += response_bytes;
    }
    request.bus_time = bus_times_.rounded_up(time);
    if (request.period && *request.period > Duration::zero())
        plan_.utilization +=
            busy_time(asked, time, transactions.size()) / static_cast<double>(bus_times_.of(*request.period));
    times_.push_back(time);
    plan_.request_count += request.count();
    plan_.requests.push_back(std::move(request));
}

LinePlan LinePlanner::finish(const std::vector<bool>& movable) && {
    number_streams(line_, plan_.requests);
    spread(line_, movable, plan_.requests);
    plan_.longest_round = longest_round(plan_.requests);
    ExactTime cycle = 0;
    for (const std::size_t request : plan_.longest_round) cycle += times_[request];
    plan_.cycle = bus_times_.rounded_up(cycle);
    return std::move(plan_);
}

std::vector<Request> requests_of(const model::Project& project, const model::Line& line,
                                 const model::Device& device, Strategy strategy) {
    if (strategy == Strategy::optimal) return optimal_requests(project, line, device);
    return with_bit_writes(project, device, strategy, device_requests(project, line, device, strategy));
}

/// The load of a plan so far, and the number of planned variables.
struct TrialLoad {
    PollingLoad load;
    std::size_t& planned;
};

/// @param trial  if given, the plan ends where it surely exceeds the line
std::optional<LinePlan> plan_devices(const model::Project& project, std::size_t index, const Options& options,
                                     TrialLoad* trial) {
    const model::Line& line = project.lines[index];
    LinePlanner planner(project, index);
    std::vector<bool> movable(line.devices.size());
    for (const std::size_t device : by_address(line.devices)) {
        const model::Device& asked = line.devices[device];
        const Strategy strategy = strategy_of(asked, options);
        const std::size_t before = planner.requests().size();
        planner.add(requests_of(project, line, asked, strategy), device);
        planner.count_ungrouped(asked);
        movable[device] = strategy == Strategy::optimal;
        if (!trial) continue;
        trial->planned += asked.variables.size();
        trial->load.add(planner.requests().subspan(before));
        if (trial->load.exceeds_line()) return std::nullopt;
    }
    return std::move(planner).finish(movable);
}

}  // namespace

LinePlan plan_line(const model::Project& project, std::size_t index, const Options& options) {
    return *plan_devices(project, index, options, nullptr);
}

LinePlan priced(const model::Project& project, std::size_t line, std::vector<Request> requests) {
    LinePlanner planner(project, line);
    for (Request& request : requests) {
        const std::size_t device = request.device;
        std::vector<Request> alone;
        alone.push_back(std::move(request));
        planner.add(std::move(alone), device);
    }
    const auto& devices = project.lines[line].devices;
    for (const model::Device& device : devices) planner.count_ungrouped(device);
    return std::move(planner).finish(std::vector<bool>(devices.size()));
}

std::optional<LinePlan> trial_plan(const model::Project& project, std::size_t index, std::size_t& planned) {
    TrialLoad trial{PollingLoad(project, project.lines[index]), planned};
    return plan_devices(project, index, {}, &trial);
}

Plan make_plan(const model::Project& project, const Options& options) {
    Plan plan;
    plan.lines.reserve(project.lines.size());
    for (std::size_t i = 0; i < project.lines.size(); ++i) {
        plan.lines.push_back(plan_line(project, i, options));
        if (options.progress) options.progress(i + 1, project.lines.size());
    }
    return plan;
}

wire::Function command_function(const model::Device& device, const model::Variable& variable) {
    using wire::Function;
    TAKT_ASSERT(variable.write);
    const bool coil = wire::counts_bits(*variable.write);
    const Function single = wire::write_function(coil, true);
    const Function multiple = wire::write_function(coil, false);
    switch (device.write_single) {
        case model::WriteSingle::as_declared: return *variable.write;
        case model::WriteSingle::never: return multiple;
        case model::WriteSingle::only:
        case model::WriteSingle::allowed: break;
    }
    return variable.items() == 1 ? single : multiple;
}

}  // namespace takt::plan
