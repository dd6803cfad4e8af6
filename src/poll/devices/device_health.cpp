#include "devices/device_health.hpp"

#include <utility>

namespace takt::poll {

using value::Reason;

DeviceHealth::DeviceHealth(std::uint16_t attempts, const model::Backoff& backoff, bool enabled)
    : attempts_(attempts), enabled_(enabled), backoff_(backoff), health_(fresh()) {
    condition_.state = initial_state(false);
}

bus::Health DeviceHealth::fresh() const {
    return bus::Health(attempts_, bus::Backoff(backoff_.first, backoff_.limit));
}

DeviceState DeviceHealth::initial_state(bool link_up) const {
    if (!enabled_) return DeviceState::switched_off;
    return link_up ? DeviceState::unknown : DeviceState::link_down;
}

Reason DeviceHealth::unreachable(Reason no_link) const {
    if (!enabled_) return Reason::switched_off;
    return condition_.state == DeviceState::link_down ? no_link : Reason::not_answering;
}

// ---- switch and link

bool DeviceHealth::enable(bool on) {
    return std::exchange(enabled_, on) != on;
}

bool DeviceHealth::enter(Instant t, DeviceState state) {
    if (condition_.state == state) return false;
    condition_.state = state;
    observe(t);
    return true;
}

// A device of which nothing is known yet stays as it was found before.
void DeviceHealth::observe(Instant t) {
    auto& availability = condition_.availability;
    if (!enabled_) return availability.pause(t);
    availability.begin(t);
    switch (condition_.state) {
        case DeviceState::answering: availability.up(t); return;
        case DeviceState::not_answering: condition_.outages += availability.down(failing_since_); return;
        case DeviceState::link_down: condition_.outages += availability.down(t); return;
        case DeviceState::switched_off:
        case DeviceState::unknown: return;
    }
}

bool DeviceHealth::take_over(const DeviceHealth& old) {
    health_ = old.health_;
    failing_since_ = old.failing_since_;
    condition_ = old.condition_;
    return enabled_ == old.enabled_;
}

// ---- transactions

DeviceVerdict DeviceHealth::ended(Instant sent_at, Instant t, const OutcomeClass& outcome_class,
                                  bool others_in_flight) {
    const bool early = std::exchange(probes_early_, false);
    if (!enabled_ || outcome_class.reason == Reason::link_lost) return DeviceVerdict::ignored;
    condition_.failure = outcome_class.answered ? Reason::ok : outcome_class.reason;
    condition_.share.ended(t, outcome_class.answered);
    if (outcome_class.answered) return health_.answered() ? DeviceVerdict::returned : DeviceVerdict::answered;
    if (health_.failures() == 0) failing_since_ = sent_at;
    if (early || (!answering() && others_in_flight)) return DeviceVerdict::failed;
    return health_.failed(t) ? DeviceVerdict::lost : DeviceVerdict::failed;
}

// ---- probes

void DeviceHealth::read_started(Instant t, Duration period) {
    probes_early_ = health_.read_started(t, period);
}

}  // namespace takt::poll
