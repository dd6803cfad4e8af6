// Changes of a whole device: the link, its switch, its recovery.
#include <algorithm>
#include <functional>
#include <set>
#include <utility>

#include "run.hpp"

namespace takt::poll {

// All requests of a line stay on one grid: those planned for one instant meet there again.
void LinePoller::Run::restart_device(Instant t, DeviceRun& device, bool at_once) {
    device.health.restart();
    statuses_.restart(static_cast<std::size_t>(&device - devices_.data()));
    for (const auto index : device.requests) {
        auto& request = requests_[index];
        if (!request.read) continue;
        touch(index);
        request.read->health = device.health.fresh();
        request.read->release.follow(after(epoch_, request.plan->phase), t);
        periods_.interrupt(index);
        request.read->retry.reset();
        request.read->not_before = Instant::min();
        for (const auto v : request.variables) splits_.forget(v);
    }
    if (at_once) release_at_once(t, device);
}

// Reads each variable once without waiting for the grid. Of requests that cover the same variables, the
// longest is released.
void LinePoller::Run::release_at_once(Instant t, const DeviceRun& device) {
    std::vector<std::size_t> longest_first;
    for (const auto r : device.requests)
        if (requests_[r].read && requests_[r].read->polled) longest_first.push_back(r);
    std::ranges::stable_sort(longest_first, std::greater{},
                             [this](std::size_t r) { return requests_[r].plan->quantity; });
    std::set<std::pair<std::size_t, std::size_t>> known;  // variable, its position in the request
    for (const auto r : longest_first) {
        bool adds_variable = false;
        for (const auto v : requests_[r].variables) {
            const std::size_t part = splits_.has(v) ? requests_[r].plan->start : 0;
            adds_variable |= known.emplace(v, part).second;
        }
        if (adds_variable) requests_[r].read->release.release_at(t);
    }
}

void LinePoller::Run::set_device_state(Instant t, std::size_t device, DeviceState state) {
    if (!devices_[device].health.enter(t, state)) return;
    observe_line(t);
    if (state == DeviceState::answering) statuses_.device_back(t, device);
    if (observer_) observer_->on_device_state(t, plan_->line, device, state);
}

// The line is down when its last device is, and up with the first answer.
void LinePoller::Run::observe_line(Instant t) {
    availability_.begin(t);
    if (!link_.up_since()) {
        availability_.down(t);
        return;
    }
    bool known = true;
    std::optional<Instant> last;
    for (const auto& device : devices_) {
        if (!device.health.enabled()) continue;
        const auto& condition = device.health.condition();
        const auto down = condition.availability.down_since();
        if (condition.state == DeviceState::answering) return availability_.up(t);
        known = known && down;
        if (down) last = std::max(last.value_or(*down), *down);
    }
    if (known && last) availability_.down(*last);
    if (known && !last) availability_.up(t);  // no device is polled: the link is up
}

void LinePoller::Run::on_link(Instant t, bool up) {
    engine_.on_link(t, up);
    take_outcomes();
    if (!up) give_up_relayed(t, bus::Status::link_lost);
    if (up && link_.up_since()) return;
    if (!up && modify_.second_step()) abandon(t, value::Reason::link_lost, true);
    if (up) epoch_ = t;
    if (up)
        link_.up(t);
    else
        link_.down();
    load_.start(t);
    arbiter_.restart_round();
    for (std::size_t d = 0; d < devices_.size(); ++d) {
        auto& health = devices_[d].health;
        if (!health.enabled()) continue;
        if (!up) drop_read_backs(t, d, value::Reason::link_lost);
        if (up) restart_device(t, devices_[d], false);
        set_device_state(t, d, up ? DeviceState::unknown : DeviceState::link_down);
        health.observe(t);  // also before the link could be opened for the first time
        if (!up) degrade_device(t, d, link_.no_link(), true);
    }
    observe_line(t);
}

void LinePoller::Run::check_connection(Instant t) {
    if (line_.is_serial()) return;
    const bool answers = std::ranges::any_of(devices_, [](const DeviceRun& device) {
        return device.health.enabled() && device.health.answering();
    });
    if (!answers) link_.check(t);
}

void LinePoller::Run::switch_device(Instant t, std::size_t index, bool on) {
    auto& device = devices_[index];
    if (!device.health.enable(on)) return;
    if (on) {
        restart_device(t, device, true);
        set_device_state(t, index, link_.up_since() ? DeviceState::unknown : DeviceState::link_down);
        return;
    }
    set_device_state(t, index, DeviceState::switched_off);
    degrade_device(t, index, value::Reason::switched_off, false);
    for (const auto r : device.requests) periods_.pause(r);
    drop_pending(t, index, value::Reason::switched_off);
}

}  // namespace takt::poll
