// The queue is filled in the order of device address, then of the file. The first request that does not fit
// ends it: all later ones are removed, even smaller ones. The remaining variables are grouped again, which
// can only reduce the count.
#include "takt/plan/queue_limit.hpp"

#include <algorithm>
#include <map>
#include <tuple>

namespace takt::plan {
namespace {

/// A request with the keys of its order in the queue.
struct QueuedRequest {
    const Request* request = nullptr;
    std::size_t line = 0;
    UnitId address;
    std::size_t first_variable = 0;
};

std::vector<QueuedRequest> in_queue_order(const model::Project& project, const Plan& plan) {
    std::vector<QueuedRequest> queued;
    for (const auto& line : plan.lines)
        for (const auto& request : line.requests)
            queued.push_back({&request, line.line, project.lines[line.line].devices[request.device].address,
                              *std::min_element(request.variables.begin(), request.variables.end())});
    std::stable_sort(queued.begin(), queued.end(), [](const QueuedRequest& a, const QueuedRequest& b) {
        return std::tie(a.address, a.line, a.request->device, a.first_variable) <
               std::tie(b.address, b.line, b.request->device, b.first_variable);
    });
    return queued;
}

// One record for an entry, also where a period and a trigger both cause it.
std::size_t counted(const Plan& plan) {
    std::size_t count = 0;
    for (const auto& line : plan.lines) count += line.requests.size();
    return count;
}

void leave_out(model::Device& device, const Request& request) {
    for (const auto index : request.variables) {
        auto& variable = device.variables[index];
        if (request.read) variable.read.reset(), variable.read_trigger.reset();
        if (request.write) variable.write_on_change = false, variable.write_trigger.reset();
        // Ungrouped, a variable that can be written has an entry.
        if (request.write && device.strategy == model::Strategy::single) variable.write.reset();
    }
}

/// The variables that a device loses.
struct Loss {
    std::size_t count = 0;
    std::size_t first_variable = 0;
};
using Losses = std::map<std::tuple<UnitId, std::size_t, std::size_t>, Loss>;  // address, line, device

// The first request that does not fit ends the queue: all later ones are left out, however small.
void drop_excess_requests(model::Project& project, const Plan& plan, Losses& losses) {
    std::size_t taken = 0;
    bool full = false;
    for (const auto& entry : in_queue_order(project, plan)) {
        full = full || taken == kOwenQueue;
        if (!full) {
            ++taken;
            continue;
        }
        const auto device = entry.request->device;
        leave_out(project.lines[entry.line].devices[device], *entry.request);
        auto& loss = losses.try_emplace({entry.address, entry.line, device}, Loss{0, entry.first_variable})
                         .first->second;
        ++loss.count;
        loss.first_variable = std::min(loss.first_variable, entry.first_variable);
    }
}

}  // namespace

// Left out once, the rest is grouped anew and can only become fewer: variables go, none comes.
QueueLimit keep_to_queue(model::Project& project) {
    if (project.profile != model::Profile::owen_kc1) return {};
    QueueLimit limit;
    auto& plan = limit.plan.emplace(make_plan(project));
    Losses losses;
    for (; counted(plan) > kOwenQueue; plan = make_plan(project)) drop_excess_requests(project, plan, losses);
    for (const auto& [key, loss] : losses) {
        const auto& device = project.lines[std::get<1>(key)].devices[std::get<2>(key)];
        const auto& first = device.variables[loss.first_variable];
        limit.findings.push_back({.severity = model::Severity::warning,
                                  .code = "plan.too_many_requests",
                                  .location = first.location,
                                  .path = device.name,
                                  .value = first.name,
                                  .allowed = "1.." + std::to_string(kOwenQueue),
                                  .arguments = {{"count", std::to_string(loss.count)},
                                                {"limit", std::to_string(kOwenQueue)},
                                                {"name", first.name}}});
    }
    return limit;
}

}  // namespace takt::plan
