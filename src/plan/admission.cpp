#include "admission.hpp"

#include <algorithm>

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

namespace {

/// Of 0x17 only what lies in the range it writes.
bool is_written_by(const Request& request, const model::Variable& variable) {
    if (request.write != wire::Function::read_write_multiple_registers) return true;
    const std::uint32_t end = std::uint32_t{request.write_start} + request.write_quantity;
    return variable.write && variable.start() >= request.write_start && variable.start() < end;
}

}  // namespace

std::optional<RateLimit> admission_of(const model::Project& project, const model::Device& device,
                                      const Request& request) {
    std::optional<RateLimit> rarest;
    if (request.write)
        for (const auto index : request.variables) {
            if (!is_written_by(request, device.variables[index])) continue;
            const auto own = write_admission(project, device.variables[index]);
            if (!own) continue;
            if (!rarest) rarest = own;
            rarest = RateLimit{std::max(rarest->min_interval, own->min_interval),
                               std::min(rarest->burst, own->burst)};
        }
    const bool writes = request.write && (request.write_on_change || request.write_trigger);
    return rarest || writes ? rarest : trigger_admission(project, request.read_trigger);
}

std::optional<Duration> deadline_of(const model::Device& device, const Request& request) {
    std::optional<Duration> least;
    for (const auto index : request.variables)
        if (const auto& own = device.variables[index].deadline; own && (!least || *own < *least)) least = own;
    if (least) return least;
    if (request.period) return *request.period > Duration::zero() ? request.period : std::nullopt;
    if (request.admission) return request.admission->min_interval;
    return std::nullopt;
}

}  // namespace takt::plan
