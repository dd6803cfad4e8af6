// Quality follows time: a good value that is older than its bound becomes uncertain, also when nothing is
// read any more. The bound is the proved age where the plan has one (plan::Plan), else `max_age` of the
// variable. The age counts from the start of the transaction that read the value: no sample is older. An
// overrun is reported while it lasts.
#include <algorithm>
#include <utility>

#include "line/run.hpp"

namespace takt::poll {

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
    std::vector<AgeWatch::Watched> watched;
    for (std::size_t v = 0; v < variables_.size(); ++v) {
        if (readers[v].empty() || !variables_[v].model->used) continue;
        if (const auto bound = greatest_age(v))
            watched.push_back({v, *bound, publisher_.splits().has(v), std::move(readers[v])});
    }
    if (!ages_) ages_.emplace(store_, value::SlotId{first_slot_});
    ages_->watch(variables_.size(), watched);
}

void LinePoller::Run::expire_ages(Instant t) {
    while (const auto stale = ages_->take_stale(t)) {
        for (const auto reader : stale->readers) {
            ++requests_[reader].traffic.late_refreshes;
            periods_.forget_refresh(reader);
        }
        statuses_.values_stale(t, stale->variables, stale->readers);
    }
}

void LinePoller::Run::report_overrun(Instant t, std::size_t index, bool overrun) {
    if (observer_)
        observer_->on_overrun(t, plan_->line, index, *requests_[index].plan->period,
                              periods_.request(index).pace(), overrun);
}

void LinePoller::Run::report_overruns(Instant t) {
    while (const auto request = periods_.take_overrun(t)) report_overrun(t, *request, true);
}

}  // namespace takt::poll
