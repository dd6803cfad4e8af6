#include "takt/capture/serial_pairing.hpp"

#include <algorithm>

#include "exchanges/pdu_shape.hpp"

namespace takt::capture {
namespace {

// A unit responds within this multiple of its usual response time, but not less than kLeastWait.
constexpr std::int64_t kWaitFactor = 10;
constexpr std::int64_t kLeastWait = 100'000'000;  // ns

template <class Vector>
void erase(Vector& values, std::size_t index) {
    std::copy(values.begin() + index + 1, values.end(), values.begin() + index);
    values.pop_back();
}

}  // namespace

SerialPairing::SerialPairing(Duration timeout) : timeout_(timeout.count()) {}

std::int64_t SerialPairing::longest_wait(std::uint8_t unit) const {
    const auto usual = usual_.of(unit);
    return usual ? std::min(timeout_, std::max(kWaitFactor * *usual, kLeastWait)) : timeout_;
}

bool SerialPairing::is_due(const Waiting& waiting, std::int64_t time_ns) const {
    constexpr std::int64_t kMargin = 2;
    const auto usual = usual_.of(waiting.unit);
    return usual && time_ns - waiting.time_ns <= kMargin * *usual;
}

bool SerialPairing::answers(const Waiting& waiting, std::int64_t time_ns, std::uint8_t unit, Bytes pdu,
                            Sender sender) const {
    if (waiting.unit != unit || sender == Sender::master) return false;
    const auto& bytes = waiting.bytes;
    if (!wire::decode_response(bytes.shape(), bytes.pdu(), pdu)) return false;
    if (!std::ranges::equal(bytes.pdu(), pdu)) return true;
    const bool can_repeat = bytes.shape().repeated || !bytes.shape().decoded;
    return can_repeat && (sender == Sender::slave || time_ns - waiting.time_ns <= longest_wait(unit));
}

// The oldest request whose response is still due; else the newest one that the frame answers.
std::optional<SerialPairing::Answered> SerialPairing::answered_by(std::int64_t time_ns, std::uint8_t unit,
                                                                  Bytes pdu, Sender sender) const {
    std::optional<Answered> found;
    bool due = false;
    for (std::size_t i = 0; i < order_.size(); ++i) {
        const auto& waiting = slots_[order_[i]];
        if (!answers(waiting, time_ns, unit, pdu, sender)) continue;
        found = {due ? found->index : i, !found};
        due = due || is_due(waiting, time_ns);
    }
    return found;
}

// A response with the bytes of its request may be a repetition: it teaches no response time.
void SerialPairing::learn(const Waiting& waiting, std::int64_t time_ns, Bytes pdu) {
    if (std::ranges::equal(waiting.bytes.pdu(), pdu)) return;
    usual_.add(waiting.unit, std::clamp<std::int64_t>(time_ns - waiting.time_ns, 0, timeout_));
}

void SerialPairing::give_up(std::size_t index, Outcome& outcome) {
    outcome.given_up.push_back(order_[index]);
    erase(order_, index);
}

// A request that is repeated has no response. Others wait: another master may have sent them.
void SerialPairing::give_up_before(std::int64_t time_ns, std::uint8_t unit, Bytes pdu, Outcome& outcome) {
    for (std::size_t i = 0; i < order_.size();) {
        const auto& waiting = slots_[order_[i]];
        const auto age = time_ns - waiting.time_ns;
        const bool same = waiting.unit == unit && std::ranges::equal(waiting.bytes.pdu(), pdu);
        if (age < usual_.of(waiting.unit)) outcome.overlaps = true;
        outcome.repeats = outcome.repeats || same;
        if (same || age > longest_wait(waiting.unit))
            give_up(i, outcome);
        else
            ++i;
    }
    if (order_.full()) give_up(0, outcome);
}

SerialPairing::Slot SerialPairing::free_slot(const Outcome& outcome) const {
    const auto is_in = [](const Slots& slots, Slot slot) {
        return std::ranges::find(slots, slot) != slots.end();
    };
    Slot slot = 0;
    while (is_in(order_, slot) || is_in(outcome.given_up, slot)) ++slot;
    return slot;
}

SerialPairing::Outcome SerialPairing::on_frame(std::int64_t time_ns, std::uint8_t unit, Bytes pdu,
                                               Sender sender) {
    Outcome outcome;
    if (const auto answered = answered_by(time_ns, unit, pdu, sender)) {
        outcome.role = Role::response;
        outcome.slot = order_[answered->index];
        if (answered->only) learn(slots_[outcome.slot], time_ns, pdu);
        erase(order_, answered->index);
        return outcome;
    }
    const bool response_only =
        wire::is_exception(pdu[0]) || (!could_be_request(pdu) && could_be_response(pdu));
    if (sender == Sender::slave || (sender == Sender::unknown && response_only)) {
        outcome.role = Role::stray;
        return outcome;
    }
    give_up_before(time_ns, unit, pdu, outcome);
    outcome.slot = free_slot(outcome);
    slots_[outcome.slot] = {unit, time_ns, wire::PreparedRequest(pdu)};
    if (unit == kBroadcast.value)
        outcome.role = Role::broadcast;
    else
        order_.push_back(outcome.slot);
    return outcome;
}

SerialPairing::Slots SerialPairing::expire(std::int64_t time_ns) {
    Outcome outcome;
    for (std::size_t i = 0; i < order_.size();) {
        if (time_ns - slots_[order_[i]].time_ns >= timeout_)
            give_up(i, outcome);
        else
            ++i;
    }
    return outcome.given_up;
}

SerialPairing::Slots SerialPairing::end() {
    const auto all = order_;
    order_.clear();
    return all;
}

}  // namespace takt::capture
