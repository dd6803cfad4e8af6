// Receiving: removes echoes, assigns frames to transactions, and ends those whose deadline has passed.
#include <algorithm>

#include "takt/base/assert.hpp"
#include "takt/bus/transaction_engine.hpp"

namespace takt::bus {
namespace {

constexpr std::size_t kShortestFrame = 5;  // an exception over RTU
constexpr std::size_t kExceptionPdu = 2;

// Also if it is an exception.
bool answers_function(const wire::Frame& frame, const wire::RequestShape& request) {
    return wire::requested_function(frame.pdu[0]) == wire::requested_function(request.function);
}

// The value of two hexadecimal digits. Others give a wrong value.
std::uint8_t byte_of_digits(std::uint8_t high, std::uint8_t low) {
    const auto value = [](unsigned c) { return (c & 0x0FU) + 9 * (c >> 6U); };  // letters are above 0x40
    return static_cast<std::uint8_t>(value(high) << 4U | value(low));
}

// Damaged, with all its bytes. A response has its byte count behind unit and function, and a request its
// address.
bool is_echo(wire::Framing framing, Bytes bytes, Bytes request) {
    constexpr std::size_t kDigits = 2;
    const std::size_t at = framing == wire::Framing::ascii ? 1 + 2 * kDigits : 2;
    const std::size_t end = at + (framing == wire::Framing::ascii ? kDigits : 1);
    return bytes.size() == request.size() &&
           std::ranges::equal(bytes.subspan(at, end - at), request.subspan(at, end - at));
}

// Serial line: it would be the response, had it not another unit, or another function.
bool fits_but_for_one(const wire::Frame& frame, UnitId unit, const wire::RequestShape& request,
                      Bytes content) {
    wire::Pdu pdu;
    pdu.assign(frame.pdu);
    if (frame.unit == unit)
        pdu[0] = static_cast<std::uint8_t>(request.function | (pdu[0] & wire::kExceptionBit));
    return wire::decode_response(request, content, pdu.span()).has_value();
}

}  // namespace

using wire::FrameFault;

Mismatch TransactionSlot::mismatch(const wire::Frame& came) const {
    const auto came_function = wire::requested_function(came.pdu[0]);
    if (came.unit != unit) return {Mismatch::Part::unit, came.unit.value, unit.value};
    if (came_function != request.function) return {Mismatch::Part::function, came_function, request.function};
    return {Mismatch::Part::transaction, came.transaction, wire_id};
}

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
    outstanding_.expire(t);
}

void TransactionCore::note_activity(Instant t, std::size_t bytes) {
    const Duration length = config_.characters_time(bytes);
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
        })) {
        const Instant last_byte = std::min(t, last_activity_);
        if (echo_.holding() && t >= silence_end()) read(last_byte, echo_.release());
        find_response(last_byte);
    }
    const bool busy = t >= busy_limit() && t < silence_end();
    for (auto& slot : slots_) {
        if (slot.state == State::waiting && busy) finish(t, slot, Status::line_busy);
        if (!slot.in_flight() || t < slot.deadline) continue;
        if (slot.state == State::confirming) {
            conclude(t, slot);
            continue;
        }
        const bool cut_short = t >= silence_end() && note_cut_short(framer_.incomplete());
        // A frame that stays incomplete has a wrong length; it would swallow the next responses.
        if (numbered() && bytes_since_gap_ > 0) {
            if (observer_ && !must_reconnect_)
                observer_->on_fault(t, FrameFault::too_short, framer_.incomplete());
            must_reconnect_ = true;
            if (framer_.length_is_off() && !cut_short) {
                ++counters_.lengths_off;
                reject(HeaderFault::off_by_one, framer_.incomplete());
            }
        }
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
    return !numbered() && slot.request.fixed_length &&
           bytes_since_gap_ >= wire::frame_length(config_.framing, slot.request.response_length);
}

void TransactionCore::read(Instant t, Bytes bytes) {
    while (!bytes.empty() && !must_reconnect_) {
        const std::size_t before = framer_.incomplete().size();
        const auto step = framer_.push(t, bytes);
        if (step.fault == FrameFault::bad_header) {
            const Bytes header = framer_.dropped();
            reject(header_fault(header), header, bytes.subspan(header.size() - before));
        }
        bytes = bytes.subspan(step.consumed);
        following_ = bytes.size();
        bytes_since_gap_ += step.consumed;
        if (!anything_sent()) counters_.unsolicited_bytes += step.consumed;
        if (step.consumed == 0 && !step.complete && step.fault == FrameFault::none) return;
        handle(t, step);
    }
}

HeaderFault TransactionCore::header_fault(Bytes header) const {
    constexpr std::size_t kProtocolEnd = 4;
    return header.size() <= kProtocolEnd ? HeaderFault::protocol : HeaderFault::length;
}

void TransactionCore::reject(HeaderFault fault, Bytes beginning, Bytes rest) {
    header_fault_ = fault;
    rejected_.assign(beginning.first(std::min(beginning.size(), kMostRejected)));
    rejected_.append(rest.first(std::min(rest.size(), kMostRejected - rejected_.size())));
}

std::optional<Error> TransactionCore::rejection() const {
    if (rejected_.empty()) return std::nullopt;
    std::uint64_t number = 0;
    for (const auto byte : rejected_) number = number << 8U | byte;
    return fail(Code::not_modbus, static_cast<std::int64_t>(number),
                static_cast<std::int64_t>(rejected_.size()), static_cast<std::int64_t>(header_fault_))
        .error();
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
        if (observer_) observer_->on_fault(t, step.fault, framer_.dropped());
        noise_ += bytes_since_gap_;
        on_fault(t, step);
        bytes_since_gap_ = 0;
    }
}

void TransactionCore::on_fault(Instant t, const wire::FramerStep& step) {
    const FrameFault fault = step.fault;
    ++counters_.faults;
    if (fault == FrameFault::bad_header) must_reconnect_ = bad_header_ = true;
    if (numbered() && fault == FrameFault::too_long)
        if (Slot* slot = addressee(framer_.frame())) give_up(t, *slot, Status::unexpected_reply);
    if (fault == FrameFault::surplus || numbered()) return;
    for (auto& slot : slots_) {
        if (slot.state != State::sent || slot.broadcast) continue;
        slot.garbled = true;
        const bool echo = may_be_echo(t, slot, bytes_since_gap_);
        if (!step.whole && !(echo && is_echo(config_.framing, framer_.dropped(), outgoing_.span())))
            note_cut_short(framer_.dropped());
        if (!step.whole || echo) continue;
        // It may have been something else. That is not waited for, but remembered.
        if (!step.came) expect_response(t, slot, t);
        finish(t, slot, Status::bad_checksum);
    }
}

// A damaged echo that looks like a damaged response. Where bytes take time, the response is complete later.
bool TransactionCore::may_be_echo(Instant t, const Slot& slot, std::size_t bytes) const {
    if (!echo_.may_come()) return false;
    if (config_.echo == Echo::automatic)
        return t < slot.request_end + config_.frame_time(slot.request.response_length);
    return bytes <= outgoing_.size();
}

// Of the frame that begins so, if that is the response to the request; else 0, also if its length is unknown.
std::size_t TransactionCore::whole_length(const Slot& slot, Bytes begin) const {
    constexpr std::size_t kMbapUnit = 6;
    const bool digits = config_.framing == wire::Framing::ascii;
    const std::size_t width = digits ? 2 : 1;
    const std::size_t unit_at = numbered() ? kMbapUnit : digits ? 1 : 0;  // behind the colon
    if (begin.size() < unit_at + 2 * width) return 0;
    std::uint8_t unit = begin[unit_at];
    std::uint8_t function = begin[unit_at + width];
    if (digits) {
        unit = byte_of_digits(unit, begin[unit_at + 1]);
        function = byte_of_digits(function, begin[unit_at + 3]);
    }
    if (unit != slot.unit.value || wire::requested_function(function) != slot.request.function) return 0;
    if (numbered() && (begin[0] << 8U | begin[1]) != slot.wire_id) return 0;
    const std::size_t length = wire::is_exception(function) ? kExceptionPdu : slot.shape().pdu_length;
    return length == 0 ? 0 : wire::frame_length(config_.framing, length);
}

// @returns whether these bytes are the begin of a response, whose end is missing
bool TransactionCore::note_cut_short(Bytes begin) {
    bool noted = false;
    for (auto& slot : slots_) {
        const std::size_t whole = slot.awaits_response() ? whole_length(slot, begin) : 0;
        if (begin.size() >= whole) continue;
        slot.instead = {Mismatch::Part::length, static_cast<std::uint16_t>(begin.size()),
                        static_cast<std::uint16_t>(whole)};
        noted = true;
    }
    return noted;
}

TransactionCore::Slot* TransactionCore::addressee(const wire::Frame& frame) {
    for (auto& slot : slots_) {
        if (!slot.in_flight() || slot.broadcast || slot.unit != frame.unit) continue;
        if (numbered() && slot.wire_id != frame.transaction) continue;
        if (answers_function(frame, slot.request)) return &slot;
    }
    return nullptr;
}

void TransactionCore::on_frame(Instant t, const wire::Frame& frame) {
    if (frame.pdu.empty()) return;
    if (Slot* slot = addressee(frame)) {
        if (framer_.length_is_off()) {
            const bool cut_short = following_ == 0 && note_cut_short(framer_.raw());
            if (!cut_short) ++counters_.lengths_off;
            if (!config_.length_tolerance) {  // it is not known where the next frame begins
                must_reconnect_ = true;
                if (!cut_short) reject(HeaderFault::off_by_one, framer_.raw());
                return give_up(t, *slot, Status::unexpected_reply);
            }
        }
        if (std::ranges::equal(frame.pdu, slot->content()) && echo_.take_repetition(t))
            ++counters_.echoes;
        else
            take_response(t, *slot, frame);
        return;
    }
    const bool late = !crossed(t, frame) &&
                      settle_late(t, frame.unit, frame_shape(frame.pdu), frame.transaction) != Lateness::none;
    if (!late) {
        notify(t, frame.unit, wire::Incident::surplus_response, {}, note_foreign(frame));
        if (!numbered() || repeats(frame)) keep_surplus(t, frame.unit, frame.pdu);
    }
    pass_over(late);
}

// Framing::tcp: the response to a request that has ended.
bool TransactionCore::repeats(const wire::Frame& frame) const {
    const auto waits = [&](const Slot& slot) {
        return slot.in_flight() && slot.wire_id == frame.transaction;
    };
    return ids_.is_recent(frame.transaction) && std::ranges::none_of(slots_, waits);
}

void TransactionCore::note_surplus(Instant t, UnitId unit, Bytes pdu) {
    notify(t, unit, wire::Incident::surplus_response);
    if (!numbered()) keep_surplus(t, unit, pdu);
}

void TransactionCore::keep_surplus(Instant t, UnitId unit, Bytes pdu) {
    if (surplus_.size() == kMostSurplus) surplus_.drop_front(1);
    surplus_.push_back({unit, frame_shape(pdu), frame_hash(pdu), t});
}

// Two units have swapped their addresses: each response to the one looks like a late one of the other. A
// frame that no request had asked for was taken instead of that one before, or both were dead before.
bool TransactionCore::crossed(Instant t, const wire::Frame& frame) const {
    if (numbered() || !outstanding_.doubtful(t, frame.unit, frame_shape(frame.pdu))) return false;
    return std::ranges::any_of(slots_, [&](const Slot& slot) {
        return slot.awaits_response() && !slot.shared && slot.unit != frame.unit &&
               fits_but_for_one(frame, slot.unit, slot.request, slot.content());
    });
}

// On a serial line a frame that is no response to the request is the request of another master: then a
// response of another unit is that to the other master.
// @returns what it came instead of; of several requests the last one
std::optional<Mismatch> TransactionCore::note_foreign(const wire::Frame& frame) {
    const auto has_its_id = [&](const Slot& slot) {
        return numbered() && slot.awaits_response() && slot.wire_id == frame.transaction;
    };
    const bool known_id = std::ranges::any_of(slots_, has_its_id);
    const auto answers = [&](const Slot& slot) {
        if (!slot.awaits_response() || slot.shared) return false;
        return !numbered() || (slot.unit == frame.unit && answers_function(frame, slot.request));
    };
    std::optional<Mismatch> instead;
    for (auto& slot : slots_) {
        if (!numbered() && slot.awaits_response() &&
            !fits_but_for_one(frame, slot.unit, slot.request, slot.content())) {
            slot.shared = true;
            slot.instead.reset();
        }
        if (!(known_id ? has_its_id(slot) : answers(slot))) continue;
        instead = slot.instead = slot.mismatch(frame);
    }
    return instead;
}

// A frame that answers no request in flight, or one that another followed.
Lateness TransactionCore::settle_late(Instant end, UnitId unit, const AnswerShape& shape,
                                      std::uint16_t wire_id) {
    const std::size_t length = shape.pdu_length == 0 ? kExceptionPdu : shape.pdu_length;
    const Instant begin = end - config_.frame_time(length);
    const Lateness lateness =
        outstanding_.settle(unit, shape, numbered() ? std::optional(wire_id) : std::nullopt, begin, end);
    if (lateness != Lateness::none) note_late(end, unit, lateness);
    return lateness;
}

// Besides the own response, so it was not that one.
void TransactionCore::settle_stray(Slot& slot) {
    if (slot.stray) settle_late(slot.stray->end, slot.unit, slot.stray->shape, 0);
    slot.stray.reset();
}

// The unit may have worked on the earlier request until now.
void TransactionCore::note_late(Instant t, UnitId unit, Lateness lateness) {
    notify(t, unit, wire::Incident::late_response, outstanding_.late_by());
    for (auto& slot : slots_) {
        if (!slot.in_flight() || slot.unit != unit) continue;
        if (slot.state == State::sent) slot.unit_busy_until = t;
        if (lateness == Lateness::out_of_order) slot.in_order = false;
    }
}

void TransactionCore::pass_over(bool late) {
    ++(late ? counters_.late_answers : counters_.foreign_frames);
}

// A response is decoded here only; that of a transaction that is concluded once more.
void TransactionCore::take_response(Instant t, Slot& slot, const wire::Frame& frame) {
    const Bytes pdu = frame.pdu;
    const UnitId unit = slot.unit;
    const bool confirming = slot.state == State::confirming;
    const auto response = wire::decode_response(slot.request, slot.content(), pdu);
    if (response) settle_stray(slot);
    if (response && response->is_exception()) {
        if (confirming) return finish(t, slot, Status::ambiguous);
        if (!numbered() && outstanding_.ambiguous(unit, slot.request.function))
            outstanding_.expect_either(unit, slot.shape(), slot.deadline + slot.late_limit);
        else if (!numbered() && slot.in_order)
            outstanding_.answered(t, unit, AnswerShape{slot.request.function, 0});
        echo_.answered();
        finish(t, slot, Status::exception, *response);
    } else if (response) {
        if (!confirming) echo_.answered();
        const bool identified = slot.request.repeated;  // the response repeats the request
        const bool alone = following_ < kShortestFrame &&
                           ambiguity(t, unit, slot.shape()) == Ambiguity::none && !unusual(t, slot, pdu);
        if (confirming || (!numbered() && !identified && !alone)) return confirm(t, slot, pdu);
        if (!numbered() && slot.in_order)
            outstanding_.answered(t, unit, identified ? std::nullopt : std::optional(slot.shape()));
        finish(t, slot, Status::ok, *response);
    } else if (!numbered() && outstanding_.remembers(unit, frame_shape(pdu))) {
        settle_stray(slot);
        slot.stray = {frame_shape(pdu), t};
        if (confirming) settle_stray(slot);  // the own one has come
        pass_over(true);
    } else if (confirming) {
        pass_over(false);
        note_surplus(t, unit, pdu);
    } else {
        note_surplus(t, unit, pdu);
        give_up(t, slot, Status::unexpected_reply);
    }
}

// Later than the unit usually answers, while a response that looks alike is missing: it may be that one.
bool TransactionCore::unusual(Instant t, const Slot& slot, Bytes pdu) const {
    if (numbered() || !outstanding_.remembers(slot.unit, slot.shape())) return false;
    const Duration frame = config_.frame_time(pdu.size());
    return t - frame - slot.request_end > slot.longest_delay + config_.margin;
}

// The last frame that looks alike is the response: the ones before answered earlier requests. A frame that is
// missing follows within the time in which the unit usually answers, or is lost. A unit that does not answer
// in order may have sent them the other way round.
void TransactionCore::confirm(Instant t, Slot& slot, Bytes pdu) {
    if (slot.state == State::confirming) {
        const Lateness lateness = settle_late(slot.received_at, slot.unit, slot.shape(), 0);
        const bool in_order = lateness == Lateness::in_order && slot.in_order;
        if (!in_order && !std::ranges::equal(pdu, outgoing_.span())) slot.unordered = true;
        if (lateness == Lateness::none) note_surplus(slot.received_at, slot.unit, outgoing_.span());
        pass_over(lateness != Lateness::none);
    }
    if (unusual(t, slot, pdu)) slot.unordered = true;
    slot.state = State::confirming;
    slot.received_at = t;
    outgoing_.assign(pdu);
    slot.deadline = confirmation_end(t, slot);
    if (slot.deadline <= t && following_ < kShortestFrame) conclude(t, slot);
}

// When a response is complete that takes as long as those of the unit usually do. Over a stream its request
// and the response before it are sent on another line first, for a time that is not known here.
Instant TransactionCore::quiet_at(Instant from, const Slot& slot, std::size_t pdu_length) const {
    return from + (slot.request_end - slot.sent_at) + config_.frame_time(pdu_length) + silence_ +
           config_.margin;
}

Instant TransactionCore::confirmation_end(Instant t, const Slot& slot) const {
    const Ambiguity left = ambiguity(t, slot.unit, slot.shape());
    if (left == Ambiguity::none) return t;
    const bool independent = left == Ambiguity::passed && config_.is_serial();
    const Instant from =
        independent ? std::max(t, slot.request_end + slot.longest_delay) : t + slot.longest_delay;
    return quiet_at(from, slot, outgoing_.size());
}

// The response that is missing was lost, or it is that to this request.
void TransactionCore::conclude(Instant t, Slot& slot) {
    const bool in_doubt = slot.unordered || ambiguity(t, slot.unit, slot.shape()) > Ambiguity::begun;
    outstanding_.confirmed(t, slot.unit, slot.shape(), slot.request_end, in_doubt);
    const Instant received_at = slot.received_at;
    if (in_doubt) return finish(received_at, slot, Status::ambiguous);
    if (slot.in_order) outstanding_.answered(t, slot.unit, slot.shape());
    const auto response = wire::decode_response(slot.request, slot.content(), outgoing_.span());
    TAKT_ASSERT(response);
    finish(received_at, slot, Status::ok, *response);
}

}  // namespace takt::bus
