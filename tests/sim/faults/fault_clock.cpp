// Faults on a schedule of their own: devices that die, reboot or babble, and lines that are unplugged.
#include <algorithm>
#include <utility>

#include "fault_injector.hpp"

namespace takt::sim {

void FaultInjector::schedule(Instant t, FaultKind kind, std::optional<std::size_t> device) {
    const FaultRates& rates = device ? states_[*device].rates : plan_.rates;
    const Duration mean = rates.mean_between[static_cast<std::size_t>(kind)];
    if (!is_timed(kind) || mean <= Duration::zero() || !possible(kind, framing_, serial_)) return;
    schedule_begin(t + random_.between(Duration(1), 2 * mean), kind, device);
}

void FaultInjector::schedule_begin(Instant when, FaultKind kind, std::optional<std::size_t> device) {
    add({when, kind, device, false});
}

void FaultInjector::schedule_end(Instant when, FaultKind kind, std::optional<std::size_t> device) {
    add({when, kind, device, true});
}

void FaultInjector::add(const Timer& timer) {
    timers_.push_back(timer);
    update_next_event();
}

void FaultInjector::update_next_event() {
    next_event_ = quiet_ ? kNever : plan_.quiet_from;
    for (const Timer& timer : timers_) next_event_ = std::min(next_event_, timer.when);
}

void FaultInjector::on_event(Instant t) {
    if (!quiet_ && t >= plan_.quiet_from) fall_quiet(t);
    for (;;) {
        const auto due = std::ranges::min_element(timers_, {}, &Timer::when);
        if (due == timers_.end() || due->when > t) break;
        const Timer timer = *due;
        timers_.erase(due);
        fire(t, timer);
    }
    update_next_event();
}

void FaultInjector::fall_quiet(Instant t) {
    quiet_ = true;
    const std::vector<Timer> timers = std::exchange(timers_, {});
    for (const Timer& timer : timers)
        if (timer.ends) fire(t, timer);
    end_all(t);
}

void FaultInjector::fire(Instant t, const Timer& timer) {
    switch (timer.kind) {
        case FaultKind::device_dead:
        case FaultKind::device_reboots:
        case FaultKind::device_forgets:
            if (timer.ends)
                revive(t, timer.kind, *timer.device);
            else
                silence(t, timer.kind, *timer.device);
            return;
        default: break;
    }
    if (timer.ends)
        end(t, timer.kind);
    else
        begin(t, timer.kind, timer.device);
}

void FaultInjector::silence(Instant t, FaultKind kind, std::size_t device) {
    if (states_[device].silent || devices_[device].behaviour.dead) return schedule(t, kind, device);
    const Instant until = t + duration(kind == FaultKind::device_dead ? plan_.dead : plan_.reboot);
    states_[device].silent = devices_[device].behaviour.dead = true;
    device_died(device);
    count(t, kind, device, until);
    schedule_end(until, kind, device);
}

void FaultInjector::revive(Instant t, FaultKind kind, std::size_t device) {
    states_[device].silent = devices_[device].behaviour.dead = false;
    if (kind == FaultKind::device_dead) count(t, FaultKind::device_back, device);
    if (kind == FaultKind::device_forgets) devices_[device].forget(t);
    if (!quiet_) schedule(t, kind, device);
}

}  // namespace takt::sim
