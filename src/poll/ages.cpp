// Quality follows time: a good value that is older than its bound becomes uncertain, also when nothing is
// read any more. The bound is the proved age where the plan has one (plan::Plan), else `max_age` of the
// variable. The age counts from the start of the transaction that read the value: no sample is older. An
// overrun is reported while it lasts.
#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "ages.hpp"
#include "run.hpp"

namespace takt::poll {

using value::Quality;
using value::Reason;

std::optional<Duration> LinePoller::Run::greatest_age(std::size_t v) const {
    const auto& variable = variables_[v];
    const auto& proved = *proved_ages_;
    if (variable.device < proved.size()) {
        const auto& bound = proved[variable.device].at(index_in_device(v));
        if (bound) return bound;
    }
    return variable.model->max_age;
}

void LinePoller::Run::make_ages() {
    std::vector<std::vector<std::size_t>> readers(variables_.size());
    for (std::size_t r = 0; r < requests_.size(); ++r)
        if (requests_[r].read)
            for (const auto v : requests_[r].variables)
                if (variables_[v].model->read == requests_[r].read->request.function())
                    readers[v].push_back(r);
    std::vector<AgeLimits::Group> groups;
    std::map<std::tuple<Duration, bool, std::vector<std::size_t>>, std::uint32_t> known;
    for (std::size_t v = 0; v < variables_.size(); ++v) {
        variables_[v].age_group = AgeLimits::kNone;
        const auto bound = readers[v].empty() || !variables_[v].model->used ? std::nullopt : greatest_age(v);
        if (!bound) continue;
        const std::tuple key(*bound, variables_[v].split.has_value(), readers[v]);
        const auto [found, is_new] = known.try_emplace(key, static_cast<std::uint32_t>(groups.size()));
        if (is_new) groups.push_back({.bound = *bound, .requests = readers[v], .variables = {}});
        groups[found->second].variables.push_back(v);
        variables_[v].age_group = found->second;
    }
    ages_ = AgeLimits(std::move(groups));
    overruns_ = IndexedHeap<Instant>(requests_.size());
}

// Values that were read before this poller, or before its plan, are as old as the change.
void LinePoller::Run::watch_ages(Instant t) {
    for (const auto& variable : variables_)
        if (variable.age_group != AgeLimits::kNone && store_[variable.slot].quality == Quality::good)
            ages_.notice(variable.age_group, t);
}

// After the values of a read were published.
void LinePoller::Run::note_ages(const bus::Outcome& outcome, const RequestRun& request) {
    for (const auto v : request.variables) {
        const auto group = variables_[v].age_group;
        if (group == AgeLimits::kNone || ages_[group].read_at == outcome.ended_at) continue;
        const auto& slot = store_[variables_[v].slot];
        if (slot.quality == Quality::good && slot.good_at == outcome.ended_at)
            ages_.refresh(group, outcome.sent_at, outcome.ended_at);
    }
}

// After values were published that something else than the read of their request has read.
void LinePoller::Run::note_ages_of_updates(const bus::Outcome& outcome) {
    for (const auto& update : updates_) {
        if (update.quality != Quality::good || update.slot.value < first_slot_) continue;
        auto& variable = variables_[update.slot.value - first_slot_];
        variable.age_when_published = outcome.ended_at - outcome.sent_at;
        if (variable.age_group != AgeLimits::kNone) ages_.notice(variable.age_group, outcome.sent_at);
    }
}

void LinePoller::Run::expire_ages(Instant t) {
    while (const auto group = ages_.take_expired(t)) expire_group(t, *group);
}

void LinePoller::Run::expire_group(Instant t, std::uint32_t index) {
    auto& group = ages_[index];
    updates_.clear();
    std::optional<Instant> youngest_left;
    for (const auto v : group.variables) {
        const auto& slot = store_[variables_[v].slot];
        if (slot.quality != Quality::good) continue;
        const Instant published = slot.good_at.value_or(group.read_at);
        const Instant sampled = published - variables_[v].age_when_published;
        if (published > group.read_at && after(sampled, group.bound) >= t)
            youngest_left = std::min(youngest_left.value_or(sampled), sampled);
        else
            updates_.push_back({variables_[v].slot, std::nullopt, Quality::uncertain, Reason::stale});
    }
    if (youngest_left) ages_.notice(index, *youngest_left);
    if (updates_.empty()) return;
    store_.apply(t, updates_);
    note_stale(t, group);
}

void LinePoller::Run::note_stale(Instant t, const AgeLimits::Group& group) {
    for (const auto v : group.variables)
        if (const auto& status = variables_[v].model->status) put_status(t, *status, Reason::stale);
    for (const auto r : group.requests) requests_[r].last_reason = Reason::stale;
    set_device_status(t, variables_[group.variables.front()].device);
}

// ---- overruns

void LinePoller::Run::watch_overrun(std::size_t request) {
    const Instant due = requests_[request].read->meter.overrun_due();
    if (due != kNever)
        overruns_.put(static_cast<std::uint32_t>(request), due);
    else
        overruns_.remove(static_cast<std::uint32_t>(request));
}

void LinePoller::Run::interrupt_meter(std::size_t request) {
    requests_[request].read->meter.interrupt();
    overruns_.remove(static_cast<std::uint32_t>(request));
}

void LinePoller::Run::report_overruns(Instant t) {
    while (!overruns_.empty() && overruns_.top_key() <= t) {
        const std::size_t index = overruns_.top();
        overruns_.remove(overruns_.top());
        auto& request = requests_[index];
        for (const auto v : request.variables) variables_[v].meter.waiting(t);
        if (request.read->meter.waiting(t) && observer_)
            observer_->on_overrun(t, plan_->line, index, *request.plan->period, request.read->meter.pace(),
                                  true);
    }
}

}  // namespace takt::poll
