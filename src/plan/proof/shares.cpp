#include "takt/plan/shares.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

#include "timing/streams.hpp"

namespace takt::plan {
namespace {

bool is_endless(const Request& request) {
    return request.read && request.period == Duration::zero();
}

/// Of a request with a period.
double share_of_request(const Request& request) {
    return static_cast<double>(request.bus_time.count()) / static_cast<double>(request.period->count());
}

}  // namespace

Shares shares(const model::Line& line, const LinePlan& plan) {
    double endless = 0;  // bus time of the requests with period 0, in ns
    for (const Request& request : plan.requests)
        if (is_endless(request)) endless += static_cast<double>(request.bus_time.count());
    const double left = std::max(0.0, 1 - plan.utilization);
    Shares made{.requests = {}, .devices = std::vector<double>(line.devices.size(), 0.0)};
    for (const Request& request : plan.requests) {
        const auto time = static_cast<double>(request.bus_time.count());
        double share = 0;
        if (is_endless(request))
            share = endless > 0 ? left * time / endless : 0;
        else if (request.period > Duration::zero())
            share = share_of_request(request);
        made.requests.push_back(share);
        made.devices[request.device] += share;
    }
    return made;
}

std::vector<StreamShare> largest_shares(const LinePlan& plan, std::size_t most) {
    std::vector<StreamShare> streams;
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> known;  // device and stream
    for (const Request& request : plan.requests) {
        if (!is_periodic(request)) continue;
        const auto [entry, is_new] = known.try_emplace({request.device, request.stream}, streams.size());
        if (is_new) streams.push_back({.device = request.device});
        StreamShare& stream = streams[entry->second];
        stream.share += share_of_request(request);
        stream.variables.insert(stream.variables.end(), request.variables.begin(), request.variables.end());
    }
    std::ranges::stable_sort(streams, std::greater<>(), &StreamShare::share);
    if (streams.size() > most) streams.resize(most);
    for (auto& [device, variables, share] : streams) {
        std::ranges::sort(variables);
        const auto equal = std::ranges::unique(variables);
        variables.erase(equal.begin(), equal.end());
    }
    return streams;
}

bool is_saturated(const LinePlan& plan) {
    return std::ranges::any_of(plan.requests, is_endless);
}

double busy(const LinePlan& plan) {
    return is_saturated(plan) ? std::max(1.0, plan.utilization) : plan.utilization;
}

}  // namespace takt::plan
