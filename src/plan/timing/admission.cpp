#include "timing/admission.hpp"

#include <algorithm>

#include "takt/plan/request_job.hpp"

namespace takt::plan {

using model::RateLimit;

std::optional<RateLimit> trigger_admission(const model::Project& project,
                                           const std::optional<model::LocalIndex>& trigger) {
    if (!trigger || *trigger >= project.locals.size()) return std::nullopt;
    return project.locals[*trigger].admission;
}

std::optional<RateLimit> write_admission(const model::Project& project, const model::Variable& variable) {
    if (const auto own = trigger_admission(project, variable.write_trigger)) return own;
    return variable.write_on_change ? variable.admission : std::nullopt;
}

std::optional<RateLimit> admission_of(const model::Project& project, const model::Device& device,
                                      const Request& request) {
    std::optional<RateLimit> rarest;
    if (request.write)
        for (const auto index : request.variables) {
            if (!is_written(request, device.variables[index])) continue;
            const auto own = write_admission(project, device.variables[index]);
            if (!own) continue;
            if (!rarest) rarest = own;
            rarest = RateLimit{std::max(rarest->min_interval, own->min_interval),
                               std::min(rarest->burst, own->burst)};
        }
    const bool writes = request.write && (request.write_on_change || request.write_trigger);
    return rarest || writes ? rarest : trigger_admission(project, request.read_trigger);
}

std::optional<Duration> least_deadline(const model::Device& device, const Request& request) {
    std::optional<Duration> least;
    for (const auto index : request.variables)
        if (const auto& own = device.variables[index].deadline; own && (!least || *own < *least)) least = own;
    return least;
}

std::optional<Duration> deadline_of(const model::Device& device, const Request& request) {
    if (const auto least = least_deadline(device, request)) return least;
    if (request.period) return *request.period > Duration::zero() ? request.period : std::nullopt;
    if (request.admission) return request.admission->min_interval;
    return std::nullopt;
}

}  // namespace takt::plan
