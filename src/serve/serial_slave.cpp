// Silence handling. RTU frames end by t3.5 of silence (MODBUS over Serial Line V1.02, section 2.5.1.1).
// Adapters deliver bytes late and in blocks, so received silences are longer than those on the wire. Two
// framers therefore see the same bytes:
//   - framer_ with the configured silence decides normally;
//   - tolerant_framer_ bridges pauses up to byte_timeout. It is consulted only while framer_ holds the
//     beginning of a frame, and its result must have a valid checksum.
// A chunk that framer_ drops is reported when tolerant_framer_ ends its frame: a good frame in chunks is no
// fault, and a broken one is a single fault.
// `strict` disables the second one.
//
// After a broken frame the receiver is out of step: it cannot know whether the next bytes are the rest of
// that frame. Pieces belong to the broken frame and are not counted, until a good frame arrives or the line
// is silent for byte_timeout + kResyncSilence. A piece with the length of a whole frame is a frame of its
// own.
//
// Transmission needs t3.5 of silence after the last byte, received or sent (quiet_at_).
#include "takt/serve/serial_slave.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"
#include "takt/wire/silence.hpp"

namespace takt::serve {
namespace {

SerialConfig with_defaults(SerialConfig config) {
    if (config.byte_timeout <= Duration::zero())
        config.byte_timeout = config.framing == wire::Framing::ascii ? Duration(std::chrono::seconds(1))
                                                                     : SerialSlave::kDeliveryPause;
    if (config.frame_timeout <= Duration::zero())
        config.frame_timeout = default_frame_timeout(config.framing, config.format);
    return config;
}

wire::FramerConfig serial_framer_config(const SerialConfig& config) {
    wire::FramerConfig framer;
    framer.framing = config.framing;
    framer.side = wire::Side::slave;
    framer.silence =
        config.frame_silence > Duration::zero() ? config.frame_silence : wire::t3_5(config.format);
    constexpr int kMany = 1000;  // rounding down: a silence must not seem shorter than it is
    framer.character = wire::transmission_time(config.format, kMany) / kMany;
    if (config.strict) framer.strict_pause = wire::t1_5(config.format);
    framer.ascii_pause = config.byte_timeout;
    framer.frame_time = config.frame_timeout;
    return framer;
}

wire::FramerConfig tolerant_config(const SerialConfig& config) {
    wire::FramerConfig framer = serial_framer_config(config);
    framer.silence = std::max(framer.silence, config.byte_timeout);
    return framer;
}

EchoFilter echo_filter(const SerialConfig& config) {
    const wire::FramerConfig framer = serial_framer_config(config);
    return {config.untimed ? Duration::zero() : framer.character,
            framer.framing == wire::Framing::ascii ? framer.ascii_pause : framer.silence};
}

/// Whether bytes that are dropped for this reason may be a part of a frame.
bool is_piece(wire::FrameFault fault) {
    return fault == wire::FrameFault::checksum || fault == wire::FrameFault::too_short;
}

// Whether the answer may equal its request byte by byte.
bool repeats_request(const wire::Pdu& answer) {
    const auto& row = wire::properties(wire::Function{answer[0]});
    return row.response == wire::ResponseForm::sub_function ||
           (row.response == wire::ResponseForm::repeated && row.most_items > 0);
}

}  // namespace

Duration default_frame_timeout(wire::Framing framing, const wire::CharacterFormat& format) {
    const bool ascii = framing == wire::Framing::ascii;
    const Duration least = ascii ? Duration(std::chrono::minutes(1)) : std::chrono::seconds(2);
    return std::max(least,
                    2 * wire::transmission_time(format, ascii ? wire::kMaxAsciiFrame : wire::kMaxRtuFrame));
}

SerialSlave::SerialSlave(const SerialConfig& config, Responder& responder, wire::TrafficObserver* observer)
    : responder_(responder),
      observer_(observer),
      config_(with_defaults(config)),
      silence_(wire::frame_silence(config.framing, config.format)),
      framer_(serial_framer_config(config_)),
      tolerant_framer_(tolerant_config(config_)),
      echo_(echo_filter(config_)) {
    TAKT_ASSERT(config.framing != wire::Framing::tcp && config.format.baud > 0);
}

void SerialSlave::on_link(Instant t, bool up) {
    report_broken(t);
    out_of_step_ = false;
    up_ = up;
    framer_.reset();
    tolerant_framer_.reset();
    echo_.reset();
    counters_.unanswered += waiting_.size();
    waiting_.clear();
    quiet_at_ = after(t, silence_);
}

void SerialSlave::on_bytes(Instant t, Bytes bytes) {
    if (!up_ || bytes.empty()) return;
    const auto split = echo_.split(t, bytes);
    if (split.whole_echo) ++counters_.echoes;
    receive(split.replay_at, split.replay);
    receive(t, split.rest);
}

void SerialSlave::receive(Instant t, Bytes bytes) {
    if (bytes.empty()) return;
    quiet_at_ = std::max(quiet_at_, after(t, silence_));
    drop_stale();
    note_silence(t, bytes.size());
    while (!bytes.empty()) {
        const wire::FramerStep step = framer_.push(t, bytes);
        const Bytes taken = bytes.first(step.consumed);
        bytes = bytes.subspan(step.consumed);
        settle(t, step);
        receive_tolerant(t, taken);
    }
}

// The bytes that the framer holds may be the rest of a frame whose beginning it dropped at a silence.
void SerialSlave::receive_tolerant(Instant t, Bytes bytes) {
    if (bytes.empty() || config_.strict || config_.framing != wire::Framing::rtu) return;
    const bool inside = framer_.next_wakeup() != kNever;
    if (!inside) {  // a frame was found, or none can begin before the next silence
        report_broken(t);
        return tolerant_framer_.reset();
    }
    while (!bytes.empty()) {
        const wire::FramerStep step = tolerant_framer_.push(t, bytes);
        bytes = bytes.subspan(step.consumed);
        settle_tolerant(t, step);
        if (!step.complete || step.consumed == 0) continue;
        broken_ = {};
        take(t, tolerant_framer_);
        tolerant_framer_.reset();
        return framer_.reset();
    }
}

void SerialSlave::on_tick(Instant t) {
    if (!up_) return;
    settle(t, framer_.on_tick(t));
    settle_tolerant(t, tolerant_framer_.on_tick(t));
}

// A silence that ends a broken frame. The pieces before it belong to that frame.
void SerialSlave::note_silence(Instant t, std::size_t received) {
    const Duration sending = serial_framer_config(config_).character * static_cast<Duration::rep>(received);
    const bool silent = t - sending >= after(last_byte_at_, config_.byte_timeout + kResyncSilence);
    last_byte_at_ = t;
    if (!silent) return;
    settle(t, framer_.on_tick(t));
    settle_tolerant(t, tolerant_framer_.on_tick(t));
    out_of_step_ = false;
}

void SerialSlave::settle(Instant t, const wire::FramerStep& step) {
    if (step.fault != wire::FrameFault::none) note(t, step);
    if (!step.complete) return;
    report_broken(t);
    take(t, framer_);
    tolerant_framer_.reset();
}

// A frame that a silence completes is not taken: bytes of several frames may have a valid checksum together.
void SerialSlave::settle_tolerant(Instant t, const wire::FramerStep& step) {
    if (step.fault != wire::FrameFault::none) {
        broken_ = {};
        report(t, step, tolerant_framer_.dropped());
    } else if (step.complete && step.consumed == 0) {
        report_broken(t);
    }
}

void SerialSlave::note(Instant t, const wire::FramerStep& step) {
    if (config_.framing != wire::Framing::rtu || config_.strict || !is_piece(step.fault)) {
        broken_ = {};
        return report(t, step, framer_.dropped());
    }
    // An idle tolerant framer has reported the frame of this chunk already.
    if (tolerant_framer_.next_wakeup() == kNever) return;
    if (broken_.fault == wire::FrameFault::none) broken_ = step;
}

void SerialSlave::report(Instant t, const wire::FramerStep& step, Bytes dropped) {
    const bool rtu = config_.framing == wire::Framing::rtu;
    if (rtu && out_of_step_ && is_piece(step.fault) && !step.whole) return;
    out_of_step_ = step.fault != wire::FrameFault::surplus;
    counters_.count(step.fault);
    if (step.fault != wire::FrameFault::surplus) responder_.on_line_event(LineEvent::error);
    if (observer_) observer_->on_fault(t, step.fault, dropped);
}

void SerialSlave::report_broken(Instant t) {
    if (broken_.fault == wire::FrameFault::none) return;
    report(t, broken_, {});
    broken_ = {};
}

void SerialSlave::take(Instant t, wire::Framer& framer) {
    out_of_step_ = false;
    const wire::Frame frame = framer.frame();
    if (observer_) observer_->on_frame(t, wire::Direction::received, frame.unit, frame.pdu, framer.raw());
    responder_.on_line_event(LineEvent::message);
    const bool broadcast = frame.unit == kBroadcast;
    if (!broadcast && !responder_.serves(frame.unit)) {
        ++counters_.other_units;
        framer.expect_more();
        return;
    }
    ++(broadcast ? counters_.broadcasts : counters_.requests);
    if (Waiting* earlier = broadcast ? nullptr : waiting_of(frame.unit)) {
        // Both requests came in one block, without a silence between them: only the first one is served.
        const bool glued = earlier->asked == t;
        if (glued) counters_.count(wire::FrameFault::surplus);
        if (config_.finish_first) ++counters_.unanswered;
        if (glued || config_.finish_first) return;
        drop(*earlier);
    }
    const Context context{t, frame.unit, broadcast, config_.peer.view(), {}};
    const Answer answer = responder_.handle(context, wire::RequestView(frame.pdu));
    if (!broadcast) enqueue(t, frame.unit, answer);
}

void SerialSlave::enqueue(Instant t, UnitId unit, const Answer& answer) {
    if (answer.kind == Answer::Kind::silence || waiting_.full()) {
        ++counters_.unanswered;
        return;
    }
    const Duration delay = std::max({silence_, config_.turnaround, answer.delay});
    waiting_.push_back(
        {unit, answer.kind == Answer::Kind::pending, answer.token, t, after(t, delay), answer.pdu});
}

SerialSlave::Waiting* SerialSlave::waiting_of(UnitId unit) {
    const auto found = std::ranges::find(waiting_, unit, &Waiting::unit);
    return found == waiting_.end() ? nullptr : found;
}

void SerialSlave::drop(Waiting& waiting) {
    ++counters_.unanswered;
    waiting = waiting_.back();
    waiting_.pop_back();
}

void SerialSlave::drop_stale() {
    for (std::size_t i = waiting_.size(); i-- > 0;)
        if (!waiting_[i].pending && after(waiting_[i].due, kLatest) < quiet_at_) drop(waiting_[i]);
}

bool SerialSlave::complete(Instant t, Token token, Bytes pdu) {
    const auto found =
        std::ranges::find_if(waiting_, [token](const Waiting& w) { return w.pending && w.token == token; });
    if (found == waiting_.end()) return false;
    found->pending = false;
    found->due = std::max(found->due, t);
    found->pdu.assign(pdu);
    return true;
}

Bytes SerialSlave::transmit(Instant t) {
    if (t < quiet_at_) return {};
    Waiting* first = nullptr;
    for (Waiting& waiting : waiting_)
        if (!waiting.pending && waiting.due <= t && (!first || waiting.due < first->due)) first = &waiting;
    if (!first) return {};
    const Bytes sent = send(t, *first);
    *first = waiting_.back();
    waiting_.pop_back();
    return sent;
}

Bytes SerialSlave::send(Instant t, const Waiting& waiting) {
    out_ = wire::encode_frame(config_.framing, waiting.unit, 0, waiting.pdu.span());
    const Instant end = after(t, wire::transmission_time(config_.format, out_.size()));
    quiet_at_ = after(end, silence_);
    echo_.sent(out_.span(), repeats_request(waiting.pdu), config_.untimed ? t : end);
    // Bytes after an own frame begin a new frame, even if a pseudo-terminal delivers them at once.
    framer_.reset();
    ++counters_.answers;
    if (wire::is_exception(waiting.pdu[0])) ++counters_.exceptions;
    if (observer_)
        observer_->on_frame(t, wire::Direction::sent, waiting.unit, waiting.pdu.span(), out_.span());
    return out_.span();
}

Instant SerialSlave::next_wakeup() const {
    Instant next = framer_.next_wakeup();
    if (broken_.fault != wire::FrameFault::none) next = std::min(next, tolerant_framer_.next_wakeup());
    for (const Waiting& waiting : waiting_)
        if (!waiting.pending) next = std::min(next, std::max(waiting.due, quiet_at_));
    return next;
}

}  // namespace takt::serve
