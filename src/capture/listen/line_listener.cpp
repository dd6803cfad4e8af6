#include "takt/capture/line_listener.hpp"

#include <algorithm>

#include "serial/serial_frame.hpp"
#include "takt/base/inplace_vector.hpp"

namespace takt::capture {

using capture::SerialPairing;

LineListener::LineListener(const ListenConfig& config, ListenObserver& observer)
    : config_(config), observer_(observer), finder_(config.frames, *this), pairing_(config.timeout) {}

void LineListener::on_tick(Instant t) {
    finder_.on_tick(t);
    give_up(pairing_.expire(t.time_since_epoch().count()), Outcome::unanswered);
}

Instant LineListener::next_wakeup() const {
    Instant next = finder_.next_wakeup();
    for (const auto& request : waiting_)
        if (request) next = std::min(next, after(request->end, config_.timeout));
    return next;
}

void LineListener::on_captured(Instant t, Bytes frame, capture::Sender sender) {
    const auto decoded = capture::decode_serial(frame);
    if (decoded.size() < 2) return on_captured_damage(t, frame);
    on_frame({.begin = t, .end = t, .unit = decoded[0], .pdu = decoded.span().subspan(1), .raw = frame},
             sender);
}

void LineListener::end() {
    finder_.end();
    give_up(pairing_.end(), Outcome::open);
}

void LineListener::on_damaged(const DamagedBytes& damaged) {
    statistics_.on_damaged(damaged);
    observer_.on_damaged(damaged);
}

void LineListener::on_frame(const LineFrame& frame, capture::Sender sender) {
    statistics_.on_frame(frame);
    give_up(pairing_.expire(frame.begin.time_since_epoch().count()), Outcome::unanswered);
    const auto outcome =
        pairing_.on_frame(frame.end.time_since_epoch().count(), frame.unit, frame.pdu, sender);
    give_up(outcome.given_up, Outcome::unanswered);
    switch (outcome.role) {
        case SerialPairing::Role::stray:
            statistics_.on_stray(frame);
            observer_.on_stray(frame);
            break;
        case SerialPairing::Role::response: {
            const auto time = std::max(frame.begin - waiting_[outcome.slot]->end, Duration::zero());
            const bool refused = wire::is_exception(frame.pdu[0]) && frame.pdu.size() > 1;
            finish(outcome.slot, refused ? Outcome::exception : Outcome::answered, frame.pdu, time);
            break;
        }
        case SerialPairing::Role::request:
        case SerialPairing::Role::broadcast: begin_request(frame, outcome); break;
    }
}

// A master with a longer time-out repeats its request after this one has passed.
constexpr int kRepeatedWithin = 2;  // time-outs

// A request that comes again after others is the next poll, no repetition.
bool LineListener::repeats_last(const LineFrame& frame, const SerialPairing::Outcome& outcome) const {
    if (last_unit_ != frame.unit || !std::ranges::equal(last_pdu_.span(), frame.pdu)) return false;
    return outcome.repeats || (last_failed_ && frame.begin - last_end_ <= kRepeatedWithin * config_.timeout);
}

void LineListener::begin_request(const LineFrame& frame, const SerialPairing::Outcome& outcome) {
    InplaceVector<const SeenRequest*, SerialPairing::kSlots> due;
    for (const auto& request : waiting_)
        if (request) due.push_back(&*request);
    auto& request = waiting_[outcome.slot].emplace(SeenRequest{.begin = frame.begin,
                                                               .end = frame.end,
                                                               .unit = frame.unit,
                                                               .overlaps = outcome.overlaps,
                                                               .repeats = repeats_last(frame, outcome)});
    request.pdu.assign(frame.pdu);
    last_unit_ = frame.unit;
    last_pdu_ = request.pdu;
    last_slot_ = outcome.slot;
    last_end_ = frame.end;
    last_failed_ = false;
    statistics_.on_request(request, due.span());
    if (outcome.role == SerialPairing::Role::broadcast) finish(outcome.slot, Outcome::broadcast);
}

void LineListener::finish(SerialPairing::Slot slot, Outcome outcome, Bytes response, Duration response_time) {
    const Exchange exchange{
        .request = *waiting_[slot], .outcome = outcome, .response = response, .response_time = response_time};
    if (slot == last_slot_) last_failed_ = outcome == Outcome::unanswered;
    statistics_.on_exchange(exchange);
    observer_.on_exchange(exchange);
    waiting_[slot].reset();
}

void LineListener::give_up(const SerialPairing::Slots& slots, Outcome outcome) {
    for (const auto slot : slots) finish(slot, outcome);
}

}  // namespace takt::capture
