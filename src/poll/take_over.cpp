// Another project is applied: a new poller continues where the old one is (docs/architecture.md, "Applying a
// project"). Devices are the same if name, address and settings of their polling are; variables if their
// name, type and place on the wire are; requests if they read or write the same items of the same device in
// the same way.
#include <algorithm>
#include <map>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "run.hpp"
#include "takt/base/assert.hpp"

namespace takt::poll {
namespace {

using value::Reason;

auto settings(const model::Device& device) {
    return std::tie(device.name, device.address, device.attempts);
}

auto wire_place(const model::Variable& variable) {
    return std::tie(variable.name, variable.type, variable.area, variable.register_number, variable.bit,
                    variable.registers);
}

auto read_of(const plan::Request& r) {
    return std::tie(r.read, r.start, r.quantity, r.period, r.phase);
}

auto write_of(const plan::Request& r) {
    return std::tie(r.write, r.write_on_change, r.read_modify_write);
}

}  // namespace

/// Indices in the old line of the devices and variables that the new line continues.
struct LinePoller::Run::Same {
    std::vector<std::optional<std::size_t>> devices;
    std::vector<std::optional<std::size_t>> variables;

    Same(const Run& now, const Run& old) {
        std::map<std::string_view, std::size_t> device_of;
        for (std::size_t d = 0; d < old.devices_.size(); ++d)
            device_of.emplace(old.devices_[d].model->name, d);
        for (const auto& device : now.devices_) {
            const auto found = device_of.find(device.model->name);
            const bool same = found != device_of.end() &&
                              settings(*device.model) == settings(*old.devices_[found->second].model);
            devices.push_back(same ? std::optional(found->second) : std::nullopt);
        }
        std::map<std::string_view, std::size_t> variable_of;
        for (std::size_t v = 0; v < old.variables_.size(); ++v)
            variable_of.emplace(old.variables_[v].model->name, v);
        for (const auto& variable : now.variables_) {
            const auto found = variable_of.find(variable.model->name);
            const bool same = found != variable_of.end() &&
                              devices[variable.device] == old.variables_[found->second].device &&
                              wire_place(*variable.model) == wire_place(*old.variables_[found->second].model);
            variables.push_back(same ? std::optional(found->second) : std::nullopt);
        }
    }

    /// Whether the request of the new line has the variables of the old line's request, in their order.
    [[nodiscard]] bool same_variables(const std::vector<std::size_t>& now,
                                      const std::vector<std::size_t>& old) const {
        return std::ranges::equal(now, old,
                                  [this](std::size_t n, std::size_t o) { return variables[n] == o; });
    }
};

void LinePoller::Run::hold() {
    held_ = true;
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

// Writes and what verifies them; a read by trigger is pulled again where its trigger is still set.
void LinePoller::Run::consider_held(Instant t, std::optional<Candidate>& best) {
    for (std::size_t r = 0; r < requests_.size(); ++r) {
        const auto& device = devices_[requests_[r].device];
        if (write_groups_.has(r) && reachable(device) && !full(device)) consider_write(t, r, best);
    }
    commands_.for_each_startable([&](PendingCommand& command) { consider_command(t, command, best); });
    if (best) start(t, *best);
}

void LinePoller::Run::end_writes(Instant t) {
    for (std::size_t d = 0; d < devices_.size(); ++d) drop_read_backs(t, d, Reason::ok);
    commands_.end_all(t);
}

void LinePoller::Run::take_over(Instant t, Run& old) {
    TAKT_ASSERT(old.held_ && old.idle() && idle());
    old.end_writes(t);
    engine_.take_over(old.engine_);
    up_since_ = old.up_since_;
    was_up_ = old.was_up_;
    epoch_ = old.epoch_;
    last_byte_at_ = old.last_byte_at_;
    silence_allowed_ = old.silence_allowed_;
    silence_limit_ = old.silence_limit_;
    busy_time_ = old.busy_time_;
    load_ = old.load_;
    availability_ = old.availability_;
    last_trigger_ = old.last_trigger_;
    arrivals_ = old.arrivals_;
    written_values_.continue_numbers(old.written_values_);
    const Same same(*this, old);
    for (std::size_t d = 0; d < devices_.size(); ++d) take_over_device(t, old, same, d);
    for (std::size_t v = 0; v < variables_.size(); ++v) take_over_variable(old, same, v);
    for (std::size_t r = 0; r < requests_.size(); ++r) {
        if (requests_[r].read) take_over_read(t, old, same, r);
        if (write_groups_.has(r)) take_over_write(old, same, r);
        touch(r);
        if (requests_[r].read) watch_overrun(r);
    }
    ages_->begin(t);
}

// A device that is new on the line begins like one whose link just came up.
void LinePoller::Run::take_over_device(Instant t, Run& old, const Same& same, std::size_t index) {
    auto& device = devices_[index];
    const auto* const on = device.model->poll_enable
                               ? std::get_if<bool>(&store_[slots_.local(*device.model->poll_enable)].value)
                               : nullptr;
    device.enabled = !device.model->poll_enable || (on && *on);
    if (const auto before = same.devices[index]) {
        device.statistics = old.devices_[*before].statistics;
        device.failing_since = old.devices_[*before].failing_since;
        const auto& was = old.devices_[*before];
        const bool as_slow = device.wait == was.wait && device.model->turnaround == was.model->turnaround;
        device.delay_learner.take_over(was.delay_learner, as_slow);
        device.wait = device.delay_learner.wait();
        device.statistics.delays = device.delay_learner.finding();
        device.health = old.devices_[*before].health;
        if (device.enabled == old.devices_[*before].enabled) return;
    }
    if (up_since_) restart_device(t, device, false);
    set_device_state(t, index,
                     !device.enabled ? DeviceState::switched_off
                     : up_since_     ? DeviceState::unknown
                                     : DeviceState::link_down);
    observe_device(t, device);
}

void LinePoller::Run::take_over_variable(const Run& old, const Same& same, std::size_t index) {
    if (!same.variables[index]) return;
    auto& variable = variables_[index];
    const auto& before = old.variables_[*same.variables[index]];
    if (variable.model->period == before.model->period) variable.meter = before.meter;
    statuses_.carry(index, old.statuses_, *same.variables[index]);
    written_values_.take_over(index, old.written_values_, *same.variables[index]);
    write_groups_.take_over_member(index, old.write_groups_, *same.variables[index]);
}

// A request that did not exist before is read at once: its values may be new ones.
void LinePoller::Run::take_over_read(Instant t, const Run& old, const Same& same, std::size_t index) {
    auto& request = requests_[index];
    auto& read = *request.read;
    if (!same.devices[request.device]) return;
    const auto found = std::ranges::find_if(old.requests_, [&](const RequestRun& other) {
        return other.read && same.devices[request.device] == other.device &&
               read_of(*other.plan) == read_of(*request.plan) &&
               same.same_variables(request.variables, other.variables);
    });
    if (found == old.requests_.end()) {
        if (!up_since_) return;
        read.release.follow(after(epoch_, request.plan->phase), t);
        if (read.polled) read.release.release_at(t);
        return;
    }
    const auto& before = *found->read;
    request.counters = found->counters;
    request.skipped = found->skipped;
    request.attempt_time = found->attempt_time;
    statuses_.carry(index, old.statuses_.of_request(static_cast<std::size_t>(found - old.requests_.begin())));
    read.release = before.release;
    read.meter = before.meter;
    read.health = before.health;
    read.busy = before.busy;
    read.not_before = before.not_before;
    read.retry = before.retry;
    read.refusals = before.refusals;
    read.last_start = before.last_start;
    read.round = before.round;
}

// The new plan writes values that were set and are not written yet.
void LinePoller::Run::take_over_write(const Run& old, const Same& same, std::size_t index) {
    auto& request = requests_[index];
    const auto& members = write_groups_[index].members;
    for (std::size_t r = 0; r < old.requests_.size(); ++r) {
        const auto& other = old.requests_[r];
        if (!old.write_groups_.has(r) || same.devices[request.device] != other.device) continue;
        const auto& before = old.write_groups_[r];
        const bool shares = std::ranges::any_of(members, [&](std::size_t member) {
            return same.variables[member] &&
                   std::ranges::find(before.members, *same.variables[member]) != before.members.end();
        });
        if (!shares || write_of(*other.plan) != write_of(*request.plan)) continue;
        const bool same_members = same.same_variables(members, before.members);
        write_groups_.take_over(index, before, same_members);
        if (same_members && !request.read) request.counters = other.counters;
    }
}

}  // namespace takt::poll
