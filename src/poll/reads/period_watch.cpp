#include "reads/period_watch.hpp"

namespace takt::poll {

void PeriodWatch::set_requests() {
    requests_.clear();
    requests_.reserve(tables_.requests.size());
    for (const auto& request : tables_.requests)
        requests_.emplace_back(request.read ? request.plan->period.value_or(Duration::zero())
                                            : Duration::zero());
    variables_.reserve(tables_.variables.size());
    for (std::size_t v = variables_.size(); v < tables_.variables.size(); ++v)
        variables_.emplace_back(tables_.variables[v].model->period);
    refreshes_.set_requests(requests_.size());
    due_ = IndexedHeap<Instant>(requests_.size());
}

template <class Act>
void PeriodWatch::for_first_parts(std::size_t index, const Act& act) {
    const auto& request = tables_.requests[index];
    for (const auto v : request.variables)
        if (tables_.variables[v].model->start() >= request.plan->start) act(variables_[v]);
}

void PeriodWatch::watch(std::size_t request) {
    const Instant due = requests_[request].overrun_due();
    if (due != kNever)
        due_.put(static_cast<std::uint32_t>(request), due);
    else
        due_.remove(static_cast<std::uint32_t>(request));
}

bool PeriodWatch::started(Instant t, std::size_t request) {
    const bool changed = requests_[request].started(t);
    watch(request);
    for_first_parts(request, [t](PeriodMeter& meter) { meter.started(t); });
    return changed;
}

bool PeriodWatch::answered(Instant start, Instant end, std::size_t request) {
    requests_[request].answered(start);
    for_first_parts(request, [start](PeriodMeter& meter) { meter.answered(start); });
    return refreshes_.answered(start, end, request, tables_.requests[request].plan->refresh_bound);
}

void PeriodWatch::interrupt(std::size_t request) {
    requests_[request].interrupt();
    refreshes_.forget(request);
    due_.remove(static_cast<std::uint32_t>(request));
    for (const auto v : tables_.requests[request].variables) variables_[v].interrupt();
}

void PeriodWatch::pause(std::size_t request) {
    requests_[request].pause();
    refreshes_.forget(request);
    for (const auto v : tables_.requests[request].variables) variables_[v].pause();
}

std::optional<std::size_t> PeriodWatch::take_overrun(Instant t) {
    while (next_overrun() <= t) {
        const std::uint32_t request = due_.top();
        due_.remove(request);
        for (const auto v : tables_.requests[request].variables) variables_[v].waiting(t);
        if (requests_[request].waiting(t)) return request;
    }
    return std::nullopt;
}

void PeriodWatch::carry_request(std::size_t request, const PeriodMeter& before) {
    requests_[request] = before;
    watch(request);
}

}  // namespace takt::poll
