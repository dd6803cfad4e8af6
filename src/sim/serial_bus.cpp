#include "takt/sim/serial_bus.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"

namespace takt::sim {
namespace {

// An engine that asks to be woken at a moment that has passed, again and again, would stop the world.
constexpr int kMaxStepsAtOneMoment = 10'000;

std::uint8_t corrupted(std::uint8_t character, std::size_t index) {
    return static_cast<std::uint8_t>(character ^ ((0x5A + 38 * index) | 1));
}

}  // namespace

SerialBus::SerialBus(const wire::CharacterFormat& format, const Options& options)
    : format_(format), options_(options) {}

std::size_t SerialBus::attach(Engine& engine, bool hears_echo) {
    Participant participant;
    participant.engine = &engine;
    participant.hears_echo = hears_echo;
    participants_.push_back(std::move(participant));
    return participants_.size() - 1;
}

void SerialBus::set_link(Instant t, bool up) {
    now_ = std::max(now_, t);
    for (Participant& participant : participants_) {
        participant.sending.clear();
        participant.heard.clear();
        participant.delivered = 0;
        participant.end = std::min(participant.end, now_);
        participant.engine->on_link(now_, up);
    }
    for (Participant& participant : participants_) collect(participant, now_);
}

void SerialBus::run_until(Instant t) {
    int steps = 0;
    for (Instant next = next_wakeup(); next <= t; next = next_wakeup()) {
        steps = next > now_ ? 0 : steps + 1;
        TAKT_ASSERT(steps < kMaxStepsAtOneMoment);
        now_ = std::max(now_, next);
        step(now_);
    }
    now_ = std::max(now_, t);
    for (Participant& participant : participants_) collect(participant, now_);
}

Instant SerialBus::next_wakeup() const {
    Instant next = kNever;
    for (const Participant& participant : participants_) {
        next = std::min(next, participant.engine->next_wakeup());
        if (!participant.sending.empty())
            next = std::min(next, character_end(participant, chunk_end(participant) - 1));
    }
    return next;
}

void SerialBus::step(Instant t) {
    for (Participant& participant : participants_)
        if (!participant.sending.empty()) deliver(participant, t);
    for (Participant& participant : participants_) {
        if (participant.engine->next_wakeup() > t) continue;
        participant.engine->on_tick(t);
        participant.touched = true;
    }
    for (Participant& participant : participants_)
        if (participant.touched) collect(participant, t);
}

void SerialBus::deliver(Participant& sender, Instant t) {
    const std::size_t until = chunk_end(sender);
    if (character_end(sender, until - 1) > t) return;
    for (std::size_t i = sender.delivered; i < until; ++i) {
        const bool collides = overlapped(sender, i == 0 ? sender.start : character_end(sender, i - 1),
                                         character_end(sender, i));
        sender.collided = sender.collided || collides;
        sender.heard.push_back(collides ? corrupted(sender.sending[i], i) : sender.sending[i]);
    }
    const Bytes chunk = Bytes(sender.heard).subspan(sender.delivered);
    sender.delivered = until;
    for (Participant& listener : participants_) {
        const bool listens = &listener == &sender ? listener.hears_echo : listener.sending.empty();
        if (!listens) continue;
        listener.engine->on_bytes(t, chunk);
        listener.touched = true;
    }
    if (sender.delivered == sender.sending.size()) finish(sender);
}

void SerialBus::finish(Participant& sender) {
    if (observer_)
        observer_->on_transmission({static_cast<std::size_t>(&sender - participants_.data()), sender.start,
                                    sender.end, sender.sending, sender.collided});
    sender.sending.clear();
    sender.heard.clear();
    sender.delivered = 0;
    sender.touched = true;
}

void SerialBus::collect(Participant& participant, Instant t) {
    participant.touched = false;
    for (Bytes bytes = participant.engine->transmit(t); !bytes.empty();
         bytes = participant.engine->transmit(t)) {
        if (participant.sending.empty()) {
            participant.start = t;
            participant.collided = false;
        }
        participant.sending.insert(participant.sending.end(), bytes.begin(), bytes.end());
        participant.end = character_end(participant, participant.sending.size() - 1);
    }
}

Instant SerialBus::character_end(const Participant& sender, std::size_t index) const {
    return sender.start + wire::transmission_time(format_, index + 1);
}

std::size_t SerialBus::chunk_end(const Participant& sender) const {
    const std::size_t size = sender.sending.size();
    return options_.chunk == 0 ? size : std::min(size, sender.delivered + options_.chunk);
}

bool SerialBus::overlapped(const Participant& sender, Instant from, Instant to) const {
    return std::ranges::any_of(participants_, [&](const Participant& other) {
        return &other != &sender && other.start < to && other.end > from;
    });
}

}  // namespace takt::sim
