#include "takt/plan/compare.hpp"

#include <algorithm>
#include <map>
#include <ranges>

#include "cost/exact_time.hpp"
#include "requests/grouping.hpp"
#include "takt/base/assert.hpp"
#include "takt/plan/shares.hpp"

namespace takt::plan {
namespace {

using model::Strategy;

bool writes(const Request& request) {
    return request.write_on_change || request.write_trigger;
}

/// Read and write of a request count as one transaction each.
bool writes_apart(const Request& request) {
    return request.read && request.write && request.write_quantity == 0 && writes(request);
}

/// A write by command only belongs to no plan: strategy `single` alone has it in a request.
bool is_sent(const Request& request) {
    return request.read || writes(request);
}

void add_rates(Cost& cost, const Request& request) {
    if (!request.period || *request.period == Duration::zero()) return;
    const double per_second = 1e9 / static_cast<double>(request.period->count());
    cost.requests_per_second += per_second;
    cost.bytes_per_second += per_second * static_cast<double>(request.request_bytes + request.response_bytes);
}

bool takes_turns(const LinePlan& plan) {
    std::map<std::size_t, Duration> phases;
    return std::ranges::any_of(plan.requests, [&](const Request& request) {
        return request.period &&
               phases.try_emplace(request.stream, request.phase).first->second != request.phase;
    });
}

Cost cost_of(const model::Line& line, const LinePlan& plan) {
    const BusTimeModel bus_times(line);
    ExactTime bus_time = 0;
    Cost cost;
    cost.requests = request_counts(line, plan).grouped;
    cost.cycle = plan.cycle;
    cost.utilization = busy(plan);
    cost.saturated = is_saturated(plan);
    const auto add = [&](const Transactions& transactions, const model::Device& device) {
        for (const auto& [asked, answered] : transactions) cost.bytes += asked + answered;
        bus_time += bus_times.sum(device, transactions, estimated_turnaround(device));
    };
    for (const Request& request : plan.requests | std::views::filter(is_sent)) {
        const model::Device& device = line.devices[request.device];
        add(main_transactions(line.framing, request), device);
        if (writes_apart(request)) add(write_transactions(line.framing, request), device);
        add_rates(cost, request);
    }
    cost.takes_turns = takes_turns(plan);
    cost.bus_time = bus_times.rounded_up(bus_time);
    return cost;
}

double percent_saved(double cost, double single) {
    return single > 0 ? (single - cost) / single * 100 : 0;
}

double percent_saved(std::size_t cost, std::size_t single) {
    return percent_saved(static_cast<double>(cost), static_cast<double>(single));
}

double percent_saved(Duration cost, Duration single) {
    return percent_saved(static_cast<double>(cost.count()), static_cast<double>(single.count()));
}

Saving saving(const Cost& cost, const Cost& single) {
    return {.requests = percent_saved(cost.requests, single.requests),
            .bytes = percent_saved(cost.bytes, single.bytes),
            .bus_time = percent_saved(cost.bus_time, single.bus_time),
            .cycle = percent_saved(cost.cycle, single.cycle),
            .utilization = percent_saved(cost.utilization, single.utilization),
            .requests_per_second = percent_saved(cost.requests_per_second, single.requests_per_second),
            .bytes_per_second = percent_saved(cost.bytes_per_second, single.bytes_per_second)};
}

bool same_request(const Request& a, const Request& b) {
    return a.device == b.device && a.variables == b.variables && a.read == b.read && a.write == b.write &&
           a.start == b.start && a.quantity == b.quantity && a.period == b.period && a.phase == b.phase &&
           a.write_start == b.write_start && a.write_quantity == b.write_quantity;
}

bool asks_for(const model::Line& line, Strategy strategy) {
    return !line.devices.empty() && line.devices[0].strategy == strategy;
}

}  // namespace

RequestCounts request_counts(const model::Line& line, const LinePlan& plan) {
    RequestCounts counts{plan.request_count, plan.ungrouped_requests};
    counts.grouped += static_cast<std::size_t>(std::ranges::count_if(plan.requests, writes_apart));
    counts.grouped -= static_cast<std::size_t>(
        std::ranges::count_if(plan.requests, [](const auto& request) { return !is_sent(request); }));
    for (const auto& device : line.devices)
        for (const auto& v : device.variables) {
            const bool written = is_written(v, Strategy::optimal);
            if (is_read(v) && written) ++counts.ungrouped;
            if (!is_read(v) && !written && is_written(v, Strategy::single)) --counts.ungrouped;
        }
    return counts;
}

bool Comparison::takes_turns() const {
    return grouped.takes_turns ||
           std::ranges::any_of(strategies, [](const auto& each) { return each.cost.takes_turns; });
}

std::vector<Comparison> compare(const model::Project& project, const Plan& plan) {
    TAKT_ASSERT(plan.lines.size() == project.lines.size());
    constexpr std::array kStrategies{Strategy::single, Strategy::classic, Strategy::optimal};
    std::vector<Comparison> comparisons;
    for (std::size_t i = 0; i < plan.lines.size(); ++i)
        comparisons.push_back({.line = i, .grouped = cost_of(project.lines[i], plan.lines[i])});
    for (std::size_t s = 0; s < kStrategies.size(); ++s) {
        const Plan other = make_plan(project, {.strategy = kStrategies[s]});
        for (Comparison& comparison : comparisons) {
            const LinePlan& planned = other.lines[comparison.line];
            StrategyCost& each = comparison.strategies[s];
            each.strategy = kStrategies[s];
            each.cost = cost_of(project.lines[comparison.line], planned);
            each.saved = saving(each.cost, comparison.strategies[0].cost);
            if (std::ranges::equal(planned.requests, plan.lines[comparison.line].requests, same_request) &&
                (!comparison.configured || asks_for(project.lines[comparison.line], each.strategy)))
                comparison.configured = each.strategy;
        }
    }
    for (Comparison& comparison : comparisons) {
        comparison.single = comparison.strategies[0].cost;
        comparison.saved = saving(comparison.grouped, comparison.single);
    }
    return comparisons;
}

}  // namespace takt::plan
