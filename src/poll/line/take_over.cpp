// Another project is applied: a new poller continues where the old one is (docs/architecture.md, "Applying a
// project"). LineMatch knows what is the same.
#include "line/run.hpp"
#include "takt/base/assert.hpp"

namespace takt::poll {

using value::Reason;

void LinePoller::Run::hold() {
    suspended_ = true;
    give_up_held();
}

bool LinePoller::Run::idle() const {
    return engine_.idle() && !modify_.active();
}

bool LinePoller::Run::quiet() const {
    if (!idle() || !commands_.empty()) return false;
    for (std::size_t r = 0; r < requests_.size(); ++r) {
        if (!write_groups_.has(r) || !reachable(devices_[requests_[r].device])) continue;
        if (write_groups_.due(r) || write_groups_[r].progress.awaits_read_back()) return false;
    }
    return true;
}

void LinePoller::Run::end_writes(Instant t) {
    give_up_held();
    for (std::size_t d = 0; d < devices_.size(); ++d) drop_read_backs(t, d, Reason::ok);
    commands_.end_all(t);
}

void LinePoller::Run::take_over(Instant t, Run& old) {
    TAKT_ASSERT(old.suspended_ && old.idle() && idle());
    old.end_writes(t);
    engine_.take_over(old.engine_);
    link_.take_over(old.link_);
    reads_.take_over(old.reads_);
    load_ = old.load_;
    availability_ = old.availability_;
    arrivals_ = old.arrivals_;
    written_values_.continue_numbers(old.written_values_);
    const LineMatch match({variables_, devices_, requests_}, {old.variables_, old.devices_, old.requests_});
    for (std::size_t d = 0; d < devices_.size(); ++d) take_over_device(t, old, match, d);
    for (std::size_t v = 0; v < variables_.size(); ++v) take_over_variable(old, match, v);
    for (std::size_t r = 0; r < requests_.size(); ++r) {
        if (requests_[r].read) take_over_read(t, old, match, r);
        if (write_groups_.has(r)) take_over_write(old, match, r);
        offers_.note_event(r);
    }
    ages_->begin(t);
}

// A device that is new on the line begins like one whose link just came up.
void LinePoller::Run::take_over_device(Instant t, Run& old, const LineMatch& match, std::size_t index) {
    auto& device = devices_[index];
    device.health.enable(switched_on(*device.model));
    if (const auto before = match.device(index)) {
        const auto& was = old.devices_[*before];
        device.statistics = was.statistics;
        device.noise_meter = was.noise_meter;
        const bool as_slow = device.delay_learner.wait() == was.delay_learner.wait() &&
                             device.model->turnaround == was.model->turnaround;
        device.delay_learner.take_over(was.delay_learner, as_slow);
        device.times = was.times;
        if (device.health.take_over(was.health)) return;
    }
    if (link_.up_since()) restart_device(t, index);
    set_device_state(t, index, device.health.initial_state(link_.up_since().has_value()));
    device.health.observe(t);
}

void LinePoller::Run::take_over_variable(const Run& old, const LineMatch& match, std::size_t index) {
    const auto before = match.variable(index);
    if (!before) return;
    if (variables_[index].model->period == old.variables_[*before].model->period)
        periods_.carry_variable(index, old.periods_.variable(*before));
    statuses_.carry(index, old.statuses_, *before);
    written_values_.take_over(index, old.written_values_, *before);
    write_groups_.take_over_member(index, old.write_groups_, *before);
}

// A request that did not exist before is read at once: its values may be new ones.
void LinePoller::Run::take_over_read(Instant t, const Run& old, const LineMatch& match, std::size_t index) {
    auto& request = requests_[index];
    if (!match.device(request.device)) return;
    const auto found = match.read(index);
    if (!found) {
        if (!link_.up_since()) return;
        reads_.follow(t, index);
        reads_.release_at(t, index);
        return;
    }
    const auto& other = old.requests_[*found];
    request.traffic = other.traffic;
    statuses_.carry(index, old.statuses_.of_request(*found));
    periods_.carry_request(index, old.periods_.request(*found));
    reads_.take_over(index, old.reads_, *found);
    request.read->refusals = other.read->refusals;
    request.read->last_start = other.read->last_start;
}

// The new plan writes values that were set and are not written yet.
void LinePoller::Run::take_over_write(const Run& old, const LineMatch& match, std::size_t index) {
    auto& request = requests_[index];
    const auto& members = write_groups_[index].members;
    for (std::size_t r = 0; r < old.requests_.size(); ++r) {
        if (!old.write_groups_.has(r) || !match.same_write(index, r)) continue;
        const auto& before = old.write_groups_[r];
        if (!match.share_variables(members, before.members)) continue;
        const bool same_members = match.same_variables(members, before.members);
        write_groups_.take_over(index, before, same_members);
        if (!same_members || request.read) continue;
        request.traffic = old.requests_[r].traffic;
    }
}

}  // namespace takt::poll
