#include "devices/statuses.hpp"

#include <algorithm>

namespace takt::poll {

using value::Reason;

void Statuses::set_requests() {
    variables_.resize(tables_.variables.size());
    requests_.clear();
    requests_.resize(tables_.requests.size());
    for (std::size_t r = 0; r < requests_.size(); ++r)
        for (const auto v : tables_.requests[r].variables)
            if (const auto& status = tables_.variables[v].model->status;
                status && std::ranges::find(requests_[r].locals, *status) == requests_[r].locals.end())
                requests_[r].locals.push_back(*status);
}

std::vector<Reason> Statuses::of_requests() const {
    std::vector<Reason> reasons;
    for (const auto& request : requests_) reasons.push_back(request.last);
    return reasons;
}

// ---- results

void Statuses::read_ended(Instant t, std::size_t request, Reason reason) {
    note_failed(request, reason);
    requests_[request].last = reason;
    for (const auto local : requests_[request].locals) put(t, local, reason);
    show_device(t, tables_.requests[request].device);
}

void Statuses::note_failed(std::size_t request, Reason reason) {
    for (const auto v : tables_.requests[request].variables) variables_[v].last = reason;
}

void Statuses::write_ended(Instant t, std::size_t request, std::span<const std::size_t> written,
                           Reason reason) {
    for (const auto v : written) write_ended(t, v, reason);
    const std::size_t device = tables_.requests[request].device;
    if (!reachable(tables_.devices[device])) return;
    requests_[request].last = reason;
    show_device(t, device);
}

// Also of a variable that no request of the plan holds: commands alone write it.
void Statuses::write_ended(Instant t, std::size_t variable, Reason reason) {
    variables_[variable].last = reason;
    if (!reachable(tables_.devices[tables_.variables[variable].device])) return;
    variables_[variable].away = false;
    show(t, variable, reason);
}

void Statuses::values_stale(Instant t, std::span<const std::size_t> variables,
                            std::span<const std::size_t> requests) {
    for (const auto v : variables)
        if (const auto& status = tables_.variables[v].model->status) put(t, *status, Reason::stale);
    for (const auto r : requests) requests_[r].last = Reason::stale;
    show_device(t, tables_.variables[variables.front()].device);
}

// ---- devices

void Statuses::device_away(Instant t, std::size_t device, Reason reason) {
    for (const auto r : tables_.devices[device].requests) requests_[r].last = reason;
    for (std::size_t v = 0; v < variables_.size(); ++v)
        if (tables_.variables[v].device == device) show_unavailable(t, v, reason);
    show_device(t, device);
}

void Statuses::show_unavailable(Instant t, std::size_t variable, Reason reason) {
    variables_[variable].away = true;
    show(t, variable, reason);
}

void Statuses::device_back(Instant t, std::size_t device) {
    for (const auto r : tables_.devices[device].requests) {
        const auto& request = tables_.requests[r];
        if (request.read && request.read->polled)
            for (const auto v : request.variables) variables_[v].away = false;
    }
    for (std::size_t v = 0; v < variables_.size(); ++v)
        if (tables_.variables[v].device == device && variables_[v].away)
            write_ended(t, v, variables_[v].last);
}

void Statuses::restart(std::size_t device) {
    for (const auto r : tables_.devices[device].requests) requests_[r].last = Reason::ok;
}

// ---- locals

void Statuses::show(Instant t, std::size_t variable, Reason reason) {
    const auto& model = *tables_.variables[variable].model;
    if (model.used && model.status) put(t, *model.status, reason);
}

// The first request that is not ok.
void Statuses::show_device(Instant t, std::size_t index) {
    const auto& device = tables_.devices[index];
    if (!device.model->status) return;
    Reason reason = Reason::ok;
    for (const auto r : device.requests)
        if (reason == Reason::ok) reason = requests_[r].last;
    put(t, *device.model->status, reason);
}

void Statuses::put(Instant t, model::LocalIndex local, Reason reason) {
    const auto slot = slots_.local(local);
    const auto number =
        value::convert(store_.info(slot).type, false, std::int64_t{value::status_code(reason)});
    if (!number) return;  // the local is not a number
    const value::Update update{slot, *number};
    store_.apply(t, {&update, 1});
}

}  // namespace takt::poll
