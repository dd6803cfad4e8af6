// Replaces the running plan while no transaction is in flight (docs/architecture.md). Waiting triggers,
// writes and commands move to the requests of the new plan that have their variables.
#include <algorithm>
#include <tuple>
#include <utility>

#include "line/run.hpp"

namespace takt::poll {
namespace {

auto same_read(const plan::Request& r) {
    return std::tie(r.device, r.read, r.start, r.quantity, r.period, r.phase, r.read_trigger, r.variables);
}

bool holds(const RequestRun& request, std::size_t variable) {
    return std::ranges::find(request.variables, variable) != request.variables.end();
}

bool share_variables(const RequestRun& a, const RequestRun& b) {
    return std::ranges::any_of(a.variables, [&](std::size_t variable) { return holds(b, variable); });
}

}  // namespace

/// What the requests of the old plan leave behind.
struct LinePoller::Run::OldReads {
    const std::vector<RequestRun>& requests;
    ReadSchedule schedule;
    std::vector<value::Reason> reasons;
    std::vector<PeriodMeter> meters;
};

// An overrun of a request that the new plan does not have ends.
void LinePoller::Run::end_overruns(Instant t, const plan::LinePlan& next) {
    for (std::size_t r = 0; r < requests_.size() && observer_; ++r) {
        const auto& request = requests_[r];
        const bool stays = std::ranges::any_of(
            next.requests, [&](const auto& other) { return same_read(other) == same_read(*request.plan); });
        if (request.read && periods_.request(r).overrun() && !stays) report_overrun(t, r, false);
    }
}

void LinePoller::Run::swap_plan(Instant t) {
    give_up_held();
    end_overruns(t, *learner_->next_plan());
    ++plan_revision_;
    const auto old_plan = learner_->swap_plan();  // the old requests are in it
    const std::vector<RequestRun> old = std::exchange(requests_, {});
    const OldReads before{.requests = old,
                          .schedule = reads_.take_reads({variables_, devices_, old}),
                          .reasons = statuses_.of_requests(),
                          .meters = periods_.requests()};
    for (auto& device : devices_) {
        device.requests.clear();
        device.health.set_reads(false);
    }
    const auto old_groups = write_groups_.take_groups();
    add_requests();
    for (std::size_t r = 0; r < requests_.size(); ++r)
        if (write_groups_.has(r)) carry_write(old, old_groups, r);
    carry_commands();
    for (std::size_t r = 0; r < requests_.size(); ++r) {
        if (requests_[r].read) carry_read(t, before, r);
        offers_.note_event(r);
    }
    reads_.keep_due(t, before.schedule);
    ages_->begin(t);
    learner_->plan_runs(t);
}

void LinePoller::Run::carry_read(Instant t, const OldReads& before, std::size_t index) {
    const auto& old = before.requests;
    auto& request = requests_[index];
    auto& read = *request.read;
    const auto same = std::ranges::find_if(old, [&](const RequestRun& other) {
        return other.read && same_read(*other.plan) == same_read(*request.plan);
    });
    if (same != old.end()) {
        const std::size_t rank = read.rank;
        request.traffic = same->traffic;
        const auto found = static_cast<std::size_t>(same - old.begin());
        statuses_.carry(index, before.reasons[found]);
        periods_.carry_request(index, before.meters[found]);
        read = *same->read;
        read.rank = rank;
        reads_.carry(index, before.schedule, found);
        return;
    }
    if (link_.up_since()) reads_.follow(t, index);
    for (std::size_t r = 0; r < old.size(); ++r) {
        if (!old[r].read) continue;
        if (holds(old[r], request.variables.front())) statuses_.carry(index, before.reasons[r]);
        if (share_variables(old[r], request))
            read.last_start = std::max(read.last_start, old[r].read->last_start);
    }
    carry_triggers(before, index);
}

void LinePoller::Run::carry_triggers(const OldReads& before, std::size_t index) {
    const auto& request = requests_[index];
    if (!request.plan->read_trigger) return;
    for (std::size_t r = 0; r < before.requests.size(); ++r) {
        const auto& other = before.requests[r];
        if (other.read && other.device == request.device &&
            other.plan->read_trigger == request.plan->read_trigger)
            reads_.carry_trigger(index, before.schedule, r);
    }
}

void LinePoller::Run::carry_write(const std::vector<RequestRun>& old,
                                  const std::vector<std::unique_ptr<WriteGroup>>& old_groups,
                                  std::size_t index) {
    const auto before = write_groups_.carry(index, old_groups);
    if (!before || requests_[index].read) return;
    requests_[index].traffic = old[*before].traffic;
}

void LinePoller::Run::carry_commands() {
    commands_.regroup([this](PendingCommand& command) {
        if (command.group) command.group = write_groups_.on_change(command.variable);
        if (command.alone.bucket_of) command.alone.bucket_of = write_groups_.by_trigger(command.variable);
    });
}

}  // namespace takt::poll
