// Virtual time advances from event to event: the end of a character or chunk, a wake-up of an engine, a
// fault. Events of one instant are processed in this order, so that a run is reproducible:
//   1. delivery of complete characters;  2. faults;  3. on_tick() of the engines;  4. transmit() of the
//      engines.
// Within a step participants are visited in the order of attachment.
//
// Collisions: a character that overlaps in time with one of another sender arrives changed, on both sides. A
// changed frame must not be a valid frame by accident, because no master could detect that; see
// make_harmless().
#include "serial_bus.hpp"

#include <algorithm>

#include "stepping.hpp"

namespace takt::sim {
namespace {

// Bytes of one read() of a master that receives in blocks.
constexpr std::size_t kReadSize = 256;
constexpr int kMostLastCharacters = 100;

std::uint8_t corrupted(std::uint8_t character, std::size_t index) {
    return static_cast<std::uint8_t>(character ^ ((0x5A + 38 * index) | 1));
}

}  // namespace

class SerialBus::Mute final : public Engine {
public:
    void on_link(Instant, bool) override {}
    void on_bytes(Instant, Bytes) override {}
    void on_tick(Instant) override {}
    [[nodiscard]] Bytes transmit(Instant) override { return {}; }
    [[nodiscard]] Instant next_wakeup() const override { return kNever; }
};

SerialBus::SerialBus(const wire::CharacterFormat& format, const Options& options)
    : format_(format), options_(options) {
    static Mute mute;
    participants_.emplace_back().engine = &mute;
}

std::size_t SerialBus::attach(Engine& engine, bool receives_echo, bool adapted) {
    Participant participant;
    participant.engine = &engine;
    participant.receives_echo = receives_echo;
    participant.adapted = adapted;
    participants_.insert(participants_.end() - 1, std::move(participant));
    return participants_.size() - 2;
}

void SerialBus::set_link(Instant t, bool up) {
    now_ = std::max(now_, t);
    for (std::size_t i = 0; i < participants_.size(); ++i) plug(now_, i, up);
    for (Participant& participant : participants_) collect(participant, now_);
}

void SerialBus::plug(Instant t, std::size_t index, bool up) {
    now_ = std::max(now_, t);
    Participant& participant = participants_[index];
    cut_off(participant);
    participant.end = std::min(participant.end, now_);
    participant.stalled_until.reset();
    participant.buffered.clear();
    participant.up = up;
    participant.touched = true;
    participant.engine->on_link(now_, up);
}

void SerialBus::stall(std::size_t participant, Instant until, bool late_tick) {
    participants_[participant].stalled_until = until;
    participants_[participant].late_tick = late_tick;
}

void SerialBus::inject(Instant t, Bytes bytes) {
    now_ = std::max(now_, t);
    Participant& intruder = participants_.back();
    if (!intruder.up || bytes.empty()) return;
    if (intruder.characters().empty()) {
        intruder.start = now_;
        intruder.collided = false;
    }
    intruder.disturbed = true;
    intruder.instead.insert(intruder.instead.end(), bytes.begin(), bytes.end());
    intruder.end = character_end(intruder, intruder.length() - 1);
}

void SerialBus::send_from(Instant t, std::size_t participant, Bytes bytes) {
    now_ = std::max(now_, t);
    if (participants_[participant].up) send(participants_[participant], now_, bytes);
}

bool SerialBus::busy() const {
    return std::ranges::any_of(participants_, [](const Participant& p) { return p.length() > 0; });
}

void SerialBus::run_until(Instant t) {
    step_until(t, now_, [this] { return next_wakeup(); }, [this] { step(now_); });
    for (Participant& participant : participants_) collect(participant, now_);
}

Instant SerialBus::wakeup_of(const Participant& participant) const {
    return participant.stalled_until ? *participant.stalled_until : participant.engine->next_wakeup();
}

Instant SerialBus::next_wakeup() const {
    Instant next = disturber_ ? disturber_->next_event() : kNever;
    for (const Participant& participant : participants_) {
        next = std::min(next, wakeup_of(participant));
        if (participant.length() > 0)
            next = std::min(next, character_end(participant, chunk_end(participant) - 1));
    }
    return next;
}

void SerialBus::step(Instant t) {
    for (Participant& participant : participants_)
        if (participant.length() > 0) deliver(participant, t);
    if (disturber_ && disturber_->next_event() <= t) disturber_->on_event(t);
    for (Participant& participant : participants_)
        if (wakeup_of(participant) <= t) wake(participant, t);
    for (Participant& participant : participants_)
        if (participant.touched) collect(participant, t);
}

void SerialBus::wake(Participant& participant, Instant t) {
    participant.touched = true;
    if (!participant.stalled_until) {
        participant.engine->on_tick(t);
        return;
    }
    participant.stalled_until.reset();
    if (participant.late_tick) participant.engine->on_tick(t);
    const Bytes all = participant.buffered;
    for (std::size_t i = 0; i < all.size(); i += kReadSize)
        participant.engine->on_bytes(t, all.subspan(i, std::min(kReadSize, all.size() - i)));
    participant.buffered.clear();
    if (participant.engine->next_wakeup() <= t) participant.engine->on_tick(t);
}

void SerialBus::deliver(Participant& sender, Instant t) {
    const std::size_t until = chunk_end(sender);
    if (character_end(sender, until - 1) > t) return;
    const std::size_t before = sender.received.size();
    receive(sender, until);
    sender.delivered = until;
    const bool ends = sender.delivered == sender.length();
    const Bytes all = sender.received;
    for (Participant& listener : participants_) {
        const bool listens = &listener == &sender ? listener.receives_echo : listener.length() == 0;
        const Bytes received = listener.adapted ? all.subspan(before) : ends ? all : Bytes{};
        if (listens && listener.up && !received.empty()) pass_on(listener, t, received);
    }
    if (ends) finish(sender, t);
}

// Appends the received bytes up to the character `until`.
void SerialBus::receive(Participant& sender, std::size_t until) {
    const std::vector<std::uint8_t>& characters = sender.characters();
    const std::size_t end = std::min(until, characters.size());
    const auto begin_of = [&](std::size_t i) { return i == 0 ? sender.start : character_end(sender, i - 1); };
    const auto from = characters.begin() + static_cast<std::ptrdiff_t>(std::min(sender.delivered, end));
    const auto to = characters.begin() + static_cast<std::ptrdiff_t>(end);
    const std::size_t before = sender.received.size();
    sender.received.insert(sender.received.end(), from, to);
    if (!overlapped(sender, begin_of(sender.delivered), character_end(sender, until - 1))) return;
    sender.collided = true;
    for (std::size_t i = sender.delivered; i < end; ++i)
        if (overlapped(sender, begin_of(i), character_end(sender, i)))
            sender.received[i] = corrupted(sender.received[i], i);
    if (disturber_ && sender.received.size() > before) make_harmless(sender, before);
}

// Changes the last character until the damaged frame cannot be taken for a valid one. If no character helps,
// the receivers miss the rest of it.
void SerialBus::make_harmless(Participant& sender, std::size_t before) {
    for (int tries = 0; tries < kMostLastCharacters; ++tries) {
        if (!disturber_->misleads(sender.received, before, sender.sending)) return;
        ++sender.received.back();
    }
    sender.received.resize(before);
}

void SerialBus::pass_on(Participant& listener, Instant t, Bytes chunk) {
    if (listener.stalled_until) {
        const std::size_t free = kBuffer - std::min(kBuffer, listener.buffered.size());
        const Bytes kept = chunk.first(std::min(free, chunk.size()));
        listener.buffered.insert(listener.buffered.end(), kept.begin(), kept.end());
        return;
    }
    listener.engine->on_bytes(t, chunk);
    listener.touched = true;
}

void SerialBus::finish(Participant& sender, Instant t) {
    const auto index = static_cast<std::size_t>(&sender - participants_.data());
    finished_.sending.swap(sender.sending);
    finished_.received.swap(sender.received);
    const Transmission transmission{index,           sender.start,      sender.end, finished_.sending,
                                    sender.collided, finished_.received};
    cut_off(sender);
    sender.touched = true;
    if (observer_) observer_->on_transmission(transmission);
    if (disturber_) disturber_->on_arrived(t, index, transmission.bytes, transmission.received);
}

void SerialBus::cut_off(Participant& participant) {
    participant.sending.clear();
    participant.instead.clear();
    participant.received.clear();
    participant.disturbed = false;
    participant.delivered = 0;
}

void SerialBus::collect(Participant& participant, Instant t) {
    participant.touched = false;
    if (participant.stalled_until) return;
    for (Bytes bytes = participant.engine->transmit(t); !bytes.empty();
         bytes = participant.engine->transmit(t))
        send(participant, t, bytes);
}

void SerialBus::send(Participant& participant, Instant t, Bytes bytes) {
    if (participant.length() == 0) {
        participant.start = t;
        participant.collided = false;
    }
    if (disturber_) disturb(participant, t, bytes);
    participant.sending.insert(participant.sending.end(), bytes.begin(), bytes.end());
    participant.end = character_end(participant, participant.length() - 1);
}

void SerialBus::disturb(Participant& participant, Instant t, Bytes bytes) {
    pieces_.clear();
    const auto sender = static_cast<std::size_t>(&participant - participants_.data());
    const bool replaced = disturber_->on_sent(t, sender, bytes, pieces_);
    if (!replaced && !participant.disturbed) return;
    if (!participant.disturbed) participant.instead = participant.sending;
    participant.disturbed = true;
    std::vector<std::uint8_t>& instead = participant.instead;
    if (!replaced) instead.insert(instead.end(), bytes.begin(), bytes.end());
    for (const Piece& piece : pieces_) instead.insert(instead.end(), piece.bytes.begin(), piece.bytes.end());
}

Instant SerialBus::character_end(const Participant& sender, std::size_t index) const {
    return sender.start + wire::transmission_time(format_, index + 1);
}

std::size_t SerialBus::chunk_end(const Participant& sender) const {
    const std::size_t size = sender.length();
    return options_.chunk == 0 ? size : std::min(size, sender.delivered + options_.chunk);
}

bool SerialBus::overlapped(const Participant& sender, Instant from, Instant to) const {
    return std::ranges::any_of(participants_, [&](const Participant& other) {
        return &other != &sender && other.start < to && other.end > from;
    });
}

}  // namespace takt::sim
