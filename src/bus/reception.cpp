// Receiving: removes echoes, assigns frames to transactions, and ends those whose deadline has passed.
#include <algorithm>

#include "takt/bus/transaction_engine.hpp"

namespace takt::bus {

using wire::FrameFault;
using wire::Framing;

void TransactionCore::on_bytes(Instant t, Bytes bytes) {
    if (!link_up_ || bytes.empty()) return;
    notice_silence(t);
    note_activity(t, bytes.size());
    const auto noise = bytes.first(echo_.noise_before(bytes));
    read(t, noise);
    bytes = bytes.subspan(noise.size());
    const auto step = echo_.filter(t, bytes);
    if (step.echo) ++counters_.echoes;
    read(t, step.released);
    read(t, bytes.subspan(step.consumed));
    notice_deadlines(t);
}

void TransactionCore::on_tick(Instant t) {
    if (!link_up_) return;
    notice_silence(t);
    notice_deadlines(t);
    if (late_) late_->expire(t);
}

Duration TransactionCore::length_of(std::size_t characters) const {
    return config_.is_serial() ? wire::transmission_time(config_.format, characters) : Duration::zero();
}

void TransactionCore::note_activity(Instant t, std::size_t bytes) {
    const Duration length = length_of(bytes);
    if (t - length >= silence_end()) activity_since_ = t - length;
    last_activity_ = std::max(last_activity_, t);
}

void TransactionCore::notice_silence(Instant t) {
    const Instant last_byte = std::min(t, last_activity_);
    if (echo_.holding() && t >= after(last_activity_, frame_silence_)) read(last_byte, echo_.release());
    for (;;) {
        const auto step = framer_.on_tick(t);
        if (!step.complete && step.fault == FrameFault::none) return;
        handle(last_byte, step);
    }
}

void TransactionCore::notice_deadlines(Instant t) {
    if (std::ranges::any_of(slots_, [&](const Slot& slot) {
            return slot.state == State::sent && !slot.broadcast && t >= slot.deadline;
        }))
        find_response(std::min(t, last_activity_));
    const bool busy = t >= busy_limit() && t < silence_end();
    for (auto& slot : slots_) {
        if (slot.state == State::waiting && busy) finish(t, slot, Status::line_busy);
        if (slot.state != State::sent || t < slot.deadline) continue;
        // A frame that stays incomplete has a wrong length; it would swallow the next responses.
        if (config_.framing == Framing::tcp && bytes_since_gap_ > 0) must_reconnect_ = true;
        if (slot.broadcast)
            finish(t, slot, Status::ok);
        else
            give_up(t, slot, slot.garbled || all_came(slot) ? Status::bad_checksum : Status::timeout);
    }
}

// The beginning of another frame before the response may be noise, though that frame has not ended yet.
void TransactionCore::find_response(Instant t) {
    if (const auto step = framer_.find_expected(); step.complete) handle(t, step);
}

// As many bytes as the response has, and no frame: their silence may end after the deadline.
bool TransactionCore::all_came(const Slot& slot) const {
    return config_.framing != Framing::tcp && slot.request.fixed_length &&
           bytes_since_gap_ >= wire::frame_length(config_.framing, slot.request.response_length);
}

void TransactionCore::read(Instant t, Bytes bytes) {
    while (!bytes.empty() && !must_reconnect_) {
        const auto step = framer_.push(t, bytes);
        bytes = bytes.subspan(step.consumed);
        bytes_since_gap_ += step.consumed;
        if (!anything_sent()) counters_.unsolicited_bytes += step.consumed;
        if (step.consumed == 0 && !step.complete && step.fault == FrameFault::none) return;
        handle(t, step);
    }
}

void TransactionCore::handle(Instant t, const wire::FramerStep& step) {
    if (step.complete) {
        const wire::Frame frame = framer_.frame();
        if (observer_)
            observer_->on_frame(t, wire::Direction::received, frame.unit, frame.pdu, framer_.raw());
        noise_ += bytes_since_gap_ - std::min(bytes_since_gap_, framer_.raw().size());
        on_frame(t, frame);
        bytes_since_gap_ = 0;
    } else if (step.fault != FrameFault::none) {
        if (observer_) observer_->on_fault(t, step.fault);
        noise_ += bytes_since_gap_;
        on_fault(t, step);
        bytes_since_gap_ = 0;
    }
}

void TransactionCore::on_fault(Instant t, const wire::FramerStep& step) {
    const FrameFault fault = step.fault;
    ++counters_.faults;
    if (fault == FrameFault::bad_header) must_reconnect_ = true;
    if (config_.framing == Framing::tcp && fault == FrameFault::too_long)
        if (Slot* slot = addressee(framer_.frame())) give_up(t, *slot, Status::unexpected_reply);
    if (fault == FrameFault::surplus || config_.framing == Framing::tcp) return;
    for (auto& slot : slots_) {
        if (slot.state != State::sent || slot.broadcast) continue;
        slot.garbled = true;
        if (step.whole && !may_be_echo(t, slot, bytes_since_gap_)) finish(t, slot, Status::bad_checksum);
    }
}

// A damaged echo that looks like a damaged response. Where bytes take time, the response is complete later.
bool TransactionCore::may_be_echo(Instant t, const Slot& slot, std::size_t bytes) const {
    if (!echo_.may_come()) return false;
    const std::size_t expected = wire::frame_length(config_.framing, slot.request.response_length);
    if (config_.echo == Echo::automatic) return t < slot.request_end + length_of(expected);
    return bytes <= outgoing_.size();
}

TransactionCore::Slot* TransactionCore::addressee(const wire::Frame& frame) {
    const bool tcp = config_.framing == Framing::tcp;
    for (auto& slot : slots_) {
        if (slot.state != State::sent || slot.broadcast || slot.unit != frame.unit) continue;
        if (tcp && slot.wire_id != frame.transaction) continue;
        if (((frame.pdu[0] ^ slot.request.function) & 0x7FU) == 0) return &slot;
    }
    return nullptr;
}

void TransactionCore::on_frame(Instant t, const wire::Frame& frame) {
    if (frame.pdu.empty()) return;
    if (Slot* slot = addressee(frame)) {
        if (std::ranges::equal(frame.pdu, slot->content()) && echo_.take_repetition(t))
            ++counters_.echoes;
        else
            take_response(t, *slot, frame);
        return;
    }
    const bool late = settle_late(t, frame);
    if (!late && config_.framing != Framing::tcp) note_other_unit(frame);
    pass_over(late);
}

void TransactionCore::note_other_unit(const wire::Frame& frame) {
    for (auto& slot : slots_)
        if (slot.state == State::sent && !slot.broadcast && slot.unit != frame.unit &&
            ((frame.pdu[0] ^ slot.request.function) & 0x7FU) == 0)
            slot.other_unit = frame.unit;
}

// A frame that answers no request in flight.
bool TransactionCore::settle_late(Instant t, const wire::Frame& frame) {
    const bool awaited = late_ && late_->settle(frame.unit, frame.pdu);
    return measure_late(t, frame) || awaited;
}

bool TransactionCore::measure_late(Instant t, const wire::Frame& frame) {
    const bool tcp = config_.framing == Framing::tcp;
    const Instant begin = t - length_of(wire::frame_length(config_.framing, frame.pdu.size()));
    const bool known = expired_.settle(frame.unit, frame.pdu,
                                       tcp ? std::optional(frame.transaction) : std::nullopt, begin, t);
    if (known) note_late(t, frame.unit);
    return known;
}

// The unit may have worked on the earlier request until now.
void TransactionCore::note_late(Instant t, UnitId unit) {
    for (auto& slot : slots_)
        if (slot.state == State::sent && slot.unit == unit) slot.unit_busy_until = t;
}

void TransactionCore::pass_over(bool late) {
    ++(late ? counters_.late_answers : counters_.foreign_frames);
}

// A response is decoded here only.
void TransactionCore::take_response(Instant t, Slot& slot, const wire::Frame& frame) {
    const Bytes pdu = frame.pdu;
    const UnitId unit = slot.unit;
    const std::uint8_t function = slot.request.function;
    const auto response = wire::decode_response(slot.request, slot.content(), pdu);
    if (response && response->is_exception()) {
        if (late_ && late_->ambiguous(unit, function))
            late_->expect_either(unit, slot.shape(), slot.deadline + slot.late_limit);
        echo_.answered();
        finish(t, slot, Status::exception, *response);
    } else if (response) {
        echo_.answered();
        if (late_) expired_.note_response(unit, slot.shape(), slot.request_end, slot.wait);
        finish(t, slot, Status::ok, *response);
    } else if (late_ && late_->settle(unit, pdu)) {
        measure_late(t, frame);
        pass_over(true);
    } else {
        give_up(t, slot, Status::unexpected_reply);
    }
}

}  // namespace takt::bus
