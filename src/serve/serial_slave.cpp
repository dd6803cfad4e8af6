#include "takt/serve/serial_slave.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"

namespace takt::serve {
namespace {

wire::FramerConfig framer_config(const SerialConfig& config) {
    wire::FramerConfig framer;
    framer.framing = config.framing;
    framer.side = wire::Side::slave;
    framer.silence =
        config.frame_silence > Duration::zero() ? config.frame_silence : wire::t3_5(config.format);
    constexpr int kMany = 1000;  // rounds down: a silence is never taken for shorter than it is
    framer.character = wire::transmission_time(config.format, kMany) / kMany;
    if (config.strict) framer.strict_pause = wire::t1_5(config.format);
    return framer;
}

wire::FramerConfig lumps_config(const SerialConfig& config) {
    wire::FramerConfig framer = framer_config(config);
    framer.silence = std::max(framer.silence, SerialSlave::kLumps);
    return framer;
}

EchoFilter echo_filter(const SerialConfig& config) {
    const wire::FramerConfig framer = framer_config(config);
    return {config.untimed ? Duration::zero() : framer.character,
            framer.framing == wire::Framing::ascii ? framer.ascii_pause : framer.silence};
}

bool repeats_request(const wire::Pdu& answer) {
    switch (static_cast<wire::Function>(answer[0])) {
        case wire::Function::write_single_coil:
        case wire::Function::write_single_register:
        case wire::Function::diagnostics:
        case wire::Function::mask_write_register: return true;
        default: return false;
    }
}

}  // namespace

SerialSlave::SerialSlave(const SerialConfig& config, Responder& responder, wire::TrafficObserver* observer)
    : responder_(responder),
      observer_(observer),
      config_(config),
      silence_(config.framing == wire::Framing::rtu ? wire::t3_5(config.format) : Duration::zero()),
      framer_(framer_config(config)),
      lumps_(lumps_config(config)),
      echo_(echo_filter(config)) {
    TAKT_ASSERT(config.framing != wire::Framing::tcp && config.format.baud > 0);
}

void SerialSlave::on_link(Instant t, bool up) {
    up_ = up;
    framer_.reset();
    lumps_.reset();
    echo_.reset();
    counters_.unanswered += waiting_.size();
    waiting_.clear();
    quiet_at_ = after(t, silence_);
}

void SerialSlave::on_bytes(Instant t, Bytes bytes) {
    if (!up_ || bytes.empty()) return;
    const auto [replay, rest, whole_echo] = echo_.split(t, bytes);
    if (whole_echo) ++counters_.echoes;
    hear(t, replay);
    hear(t, rest);
}

void SerialSlave::hear(Instant t, Bytes bytes) {
    if (bytes.empty()) return;
    quiet_at_ = std::max(quiet_at_, after(t, silence_));
    drop_stale();
    while (!bytes.empty()) {
        const wire::FramerStep step = framer_.push(t, bytes);
        const Bytes taken = bytes.first(step.consumed);
        bytes = bytes.subspan(step.consumed);
        settle(t, step);
        hear_lump(t, taken);
    }
}

// What the framer holds as the beginning of a frame may be the rest of one that it dropped at a silence.
void SerialSlave::hear_lump(Instant t, Bytes bytes) {
    if (bytes.empty() || config_.strict || config_.framing != wire::Framing::rtu) return;
    const bool inside = framer_.next_wakeup() != kNever;
    if (!inside) return lumps_.reset();  // a frame was told, or up to the next silence nothing can be one
    while (!bytes.empty()) {
        const wire::FramerStep step = lumps_.push(t, bytes);
        bytes = bytes.subspan(step.consumed);
        if (!step.complete || step.consumed == 0) continue;
        take(t, lumps_);
        lumps_.reset();
        return framer_.reset();
    }
}

void SerialSlave::on_tick(Instant t) {
    if (up_) settle(t, framer_.on_tick(t));
}

void SerialSlave::settle(Instant t, const wire::FramerStep& step) {
    if (step.fault != wire::FrameFault::none) {
        counters_.count(step.fault);
        if (step.fault != wire::FrameFault::surplus) responder_.heard(LineEvent::error);
        if (observer_) observer_->on_fault(t, step.fault);
    }
    if (!step.complete) return;
    take(t, framer_);
    lumps_.reset();
}

void SerialSlave::take(Instant t, wire::Framer& framer) {
    const wire::Frame frame = framer.frame();
    if (observer_) observer_->on_frame(t, wire::Direction::received, frame.unit, frame.pdu, framer.raw());
    responder_.heard(LineEvent::message);
    const bool broadcast = frame.unit == kBroadcast;
    if (!broadcast && !responder_.serves(frame.unit)) {
        ++counters_.other_units;
        framer.expect_more();
        return;
    }
    ++(broadcast ? counters_.broadcasts : counters_.requests);
    if (Waiting* earlier = broadcast ? nullptr : waiting_of(frame.unit)) {
        // In one piece with the earlier one, without a silence that was seen: the first is served.
        const bool glued = earlier->asked == t;
        if (glued) counters_.count(wire::FrameFault::surplus);
        if (config_.finish_first) ++counters_.unanswered;
        if (glued || config_.finish_first) return;
        drop(*earlier);
    }
    const Context context{t, frame.unit, broadcast, config_.peer.view(), {}};
    const Answer answer = responder_.handle(context, frame.pdu);
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
    // What comes behind an own frame is a new one, however soon a pseudo-terminal delivers it.
    framer_.reset();
    ++counters_.answers;
    if ((waiting.pdu[0] & 0x80) != 0) ++counters_.exceptions;
    if (observer_)
        observer_->on_frame(t, wire::Direction::sent, waiting.unit, waiting.pdu.span(), out_.span());
    return out_.span();
}

Instant SerialSlave::next_wakeup() const {
    Instant next = framer_.next_wakeup();
    for (const Waiting& waiting : waiting_)
        if (!waiting.pending) next = std::min(next, std::max(waiting.due, quiet_at_));
    return next;
}

}  // namespace takt::serve
