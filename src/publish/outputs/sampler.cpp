#include "takt/publish/sampler.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "takt/base/assert.hpp"

namespace takt::publish {

Sampler::Sampler(host::Session& session, SamplerOwner& owner, WallClock wall_ns, Instant now)
    : session_(session), owner_(owner), wall_ns_(std::move(wall_ns)), last_event_(now) {
    TAKT_ASSERT(wall_ns_);
}

void Sampler::step(Instant now) {
    set_clocks(now);
    follow_configuration(now);
    read_events(now);
    if (current_at_ <= now) deliver_current(now);
    if (retained_at() <= now) deliver_retained(now);
    sample_due(now);
    if (flush_at_ <= now) flush();
}

void Sampler::finish(Instant now) {
    read_events(now);
    flush();
}

Instant Sampler::next_wakeup() const {
    Instant next = std::min({flush_at_, current_at_, retained_at()});
    for (const auto* feed : feeds_) next = std::min(next, feed->next_due());
    return next;
}

void Sampler::set_clocks(Instant now) {
    const auto offset = wall_ns_(now) - now.time_since_epoch().count();
    for (auto* feed : feeds_) feed->set_clock(offset);
}

void Sampler::follow_configuration(Instant now) {
    if (session_.configuration() == configuration_) return;
    flush();
    configuration_ = session_.configuration();
    feeds_ = owner_.on_configuration(now, configuration_);
    set_clocks(now);
    current_at_ = now;
}

void Sampler::read_events(Instant now) {
    while (const auto event = session_.next_event()) {
        if (session_.configuration() != configuration_) follow_configuration(now);
        if (const auto* const lost = std::get_if<host::EventsLost>(&event->body)) lost_ += lost->count;
        count_lost(now, event->t);
        last_event_ = event->t;
        on_event(*event);
    }
    count_lost(now, now);
    const bool collected = std::ranges::any_of(feeds_, [](const auto* feed) { return feed->collected(); });
    if (collected && flush_at_ == kNever) flush_at_ = now + kCollect;
}

void Sampler::on_event(const host::Event& event) {
    if (const auto* const changed = std::get_if<host::ValueChanged>(&event.body)) {
        for (auto* feed : feeds_) feed->on_change(event, *changed);
    } else if (std::holds_alternative<host::DeviceStateChanged>(event.body) ||
               std::holds_alternative<host::LinkChanged>(event.body)) {
        owner_.on_state_changed();
    }
}

// Lost events are between the last one that was read and the next one. The values that they had are known
// again from a snapshot.
void Sampler::count_lost(Instant now, Instant next_event) {
    const auto missed = session_.missed_events();
    const auto lost = std::exchange(lost_, 0) + (missed - missed_);
    missed_ = missed;
    if (lost == 0) return;
    for (auto* feed : feeds_) feed->lose(lost, last_event_, next_event);
    current_at_ = now;
}

// The events up to the end of the copy are read before it is used, so the samples of a slot stay in order.
std::optional<host::Snapshot> Sampler::take_snapshot(Instant now) {
    auto snapshot = session_.snapshot({});
    read_events(now);
    if (!snapshot || snapshot->configuration != configuration_) return std::nullopt;
    return *std::move(snapshot);
}

void Sampler::sample_due(Instant now) {
    if (!std::ranges::any_of(feeds_, [&](const auto* feed) { return feed->next_due() <= now; })) return;
    const auto snapshot = take_snapshot(now);
    if (!snapshot) return;
    for (auto* feed : feeds_) feed->on_snapshot(*snapshot);
    flush();
}

void Sampler::deliver_current(Instant now) {
    current_at_ = now + kSnapshotAgain;
    const auto snapshot = take_snapshot(now);
    if (!snapshot) return;
    // Unless events were lost again meanwhile.
    if (current_at_ > now) current_at_ = kNever;
    for (auto* feed : feeds_) feed->deliver_current(*snapshot);
    flush();
}

Instant Sampler::retained_at() const {
    const bool requested =
        std::ranges::any_of(feeds_, [](const auto* feed) { return feed->retained_requested(); });
    return requested ? retained_again_ : kNever;
}

void Sampler::deliver_retained(Instant now) {
    retained_again_ = now + kSnapshotAgain;
    const auto snapshot = take_snapshot(now);
    if (!snapshot) return;
    retained_again_ = Instant::min();
    for (auto* feed : feeds_) feed->deliver_retained(*snapshot);
    flush();
}

void Sampler::flush() {
    flush_at_ = kNever;
    for (std::size_t i = 0; i < feeds_.size(); ++i)
        if (feeds_[i]->flush()) owner_.on_enqueued(i);
}

}  // namespace takt::publish
