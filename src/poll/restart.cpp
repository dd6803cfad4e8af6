// Changes of a whole device: the link, its switch, its recovery.
#include <algorithm>
#include <utility>

#include "run.hpp"

namespace takt::poll {

void LinePoller::Run::restart_device(Instant t, std::size_t index) {
    devices_[index].health.restart();
    statuses_.restart(index);
    reads_.restart(t, index);
    for (const auto r : devices_[index].requests) {
        if (!requests_[r].read) continue;
        periods_.interrupt(r);
        publisher_.forget_parts(requests_[r].variables);
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
    if (up) {
        reads_.set_origin(t);
        link_.up(t);
    } else {
        link_.down();
    }
    load_.start(t);
    arbiter_.restart_round();
    for (std::size_t d = 0; d < devices_.size(); ++d) {
        auto& health = devices_[d].health;
        if (!health.enabled()) continue;
        if (!up) drop_read_backs(t, d, value::Reason::link_lost);
        if (up) restart_device(t, d);
        set_device_state(t, d, health.initial_state(up));
        health.observe(t);  // also before the link could be opened for the first time
        if (!up) degrade_device(t, d, link_.no_link(), Shown::initial);
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
        restart_device(t, index);
        reads_.release_at_once(t, index, publisher_.splits());
        set_device_state(t, index, device.health.initial_state(link_.up_since().has_value()));
        return;
    }
    set_device_state(t, index, DeviceState::switched_off);
    degrade_device(t, index, value::Reason::switched_off, Shown::last);
    for (const auto r : device.requests) periods_.pause(r);
    drop_pending(t, index, value::Reason::switched_off);
}

}  // namespace takt::poll
