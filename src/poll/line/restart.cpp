// Changes of a whole device: the link, its switch, its recovery.
#include <algorithm>
#include <utility>

#include "line/run.hpp"

namespace takt::poll {

void LinePoller::Run::restart_device(Instant t, std::size_t index) {
    resume_device(index);
    reads_.restart(t, index);
}

// Nothing is known of it any more. Its reads are due when they were due before.
void LinePoller::Run::resume_device(std::size_t index) {
    devices_[index].health.restart();
    statuses_.restart(index);
    reads_.resume(index);
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
    if (observer_)
        observer_->on_device_state(t, plan_->line, device, state,
                                   devices_[device].health.condition().failure);
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
    if (up)
        link_opened(t);
    else
        link_lost(t);
}

// Only the first link sets the origin of the schedule.
void LinePoller::Run::link_opened(Instant t) {
    const LinkState before = link_.state();
    link_.up(t);
    if (before == LinkState::up || before == LinkState::closed) return;
    load_.start(t);
    closes_.reset();
    if (before == LinkState::none) {
        reads_.set_origin(t);
        arbiter_.restart_round();
    }
    for (std::size_t d = 0; d < devices_.size(); ++d) {
        if (!devices_[d].health.enabled()) continue;
        if (before == LinkState::none)
            restart_device(t, d);
        else
            resume_device(d);
        set_device_state(t, d, devices_[d].health.initial_state(true));
        devices_[d].health.observe(t);
    }
    observe_line(t);
}

void LinePoller::Run::link_lost(Instant t) {
    give_up_relayed(t, bus::Status::link_lost);
    if (modify_.second_step()) abandon(t, value::Reason::link_lost, true);
    link_.lost();
    load_.start(t);
    for (std::size_t d = 0; d < devices_.size(); ++d) {
        auto& health = devices_[d].health;
        if (!health.enabled()) continue;
        drop_read_backs(t, d, value::Reason::link_lost);
        set_device_state(t, d, health.initial_state(false));
        health.observe(t);  // also before the link could be opened for the first time
        degrade_device(t, d, link_.no_link(), Shown::initial);
    }
    observe_line(t);
}

// A peer that closes after each response does so before it receives the next request: no response ever came
// as soon after a request. Such a close is not held against a read, once in a row.
bool LinePoller::Run::spare(Instant t, const bus::TransactionCore::Awaited& waiting) {
    if (kind_of(waiting.id) != JobKind::read || link_.answers() == 0 || engine_.must_reconnect())
        return false;
    const auto read = index_of(waiting.id);
    const auto& times = devices_[requests_[read].device].statistics.counters.time;
    if (reads_.spared(read) || (times.count() > 0 && t - waiting.sent_at >= times.min())) return false;
    reads_.spare(read);
    return true;
}

// A close names a request only if no other one was in flight since it was sent: the peer may have closed for
// one that ended meanwhile.
void LinePoller::Run::on_close(Instant t) {
    if (line_.is_serial() || link_.state() != LinkState::up) return on_link(t, false);
    if (engine_.bad_header() && !link_.speaks_modbus()) return on_link(t, false);
    const auto waiting = engine_.awaited();
    const std::size_t count = engine_.responses_awaited();
    const bool several = count > 1 || (waiting && link_.last_end() > waiting->sent_at);
    const bool named = waiting && !several && !spare(t, *waiting);
    if (several)
        closes_.closed(std::max<std::size_t>(count, 2));
    else if (named)
        closes_.closed(1);
    if (named || !waiting)
        engine_.on_close(t);
    else
        engine_.on_link(t, false);  // no request fails
    take_outcomes();
    const auto spoken_for = [this](const DeviceRun& device) {
        const bool is_asked = device.health.enabled() && device.health.answering();
        return !is_asked || closes_.met_by(device.model->address);
    };
    if (closes_.met_by_several() && std::ranges::all_of(devices_, spoken_for)) return link_lost(t);
    link_.closed(t, named);
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
