#include "takt/serve/tcp_connection.hpp"

#include <algorithm>

namespace takt::serve {
namespace {

wire::FramerConfig framer_config(const TcpConfig& config) {
    wire::FramerConfig framer;
    framer.framing = config.framing;
    framer.side = wire::Side::slave;
    framer.silence = config.stream_pause;
    return framer;
}

Instant deadline(Instant since, Duration length) {
    return length > Duration::zero() ? after(since, length) : kNever;
}

}  // namespace

std::string_view name(CloseReason reason) {
    switch (reason) {
        case CloseReason::none: return "none";
        case CloseReason::bad_header: return "bad_header";
        case CloseReason::frame_deadline: return "frame_deadline";
        case CloseReason::idle_deadline: return "idle_deadline";
        case CloseReason::too_much: return "too_much";
    }
    return "unknown";
}

TcpConnection::TcpConnection(const TcpConfig& config, Responder& responder, wire::TrafficObserver* observer)
    : responder_(responder), observer_(observer), config_(config), framer_(framer_config(config), true) {}

void TcpConnection::on_link(Instant t, bool up) {
    up_ = up;
    close_ = CloseReason::none;
    last_bytes_ = t;
    frame_since_ = kNever;
    framer_.reset();
    input_.clear();
    out_.clear();
    out_sent_ = false;
    if (waits_ != Waits::no) ++counters_.unanswered;
    waits_ = Waits::no;
}

void TcpConnection::on_bytes(Instant t, Bytes bytes) {
    forget_sent();
    if (!up_ || close_ != CloseReason::none || bytes.empty()) return;
    if (bytes.size() > wants_bytes()) {
        close(CloseReason::too_much);
        return;
    }
    last_bytes_ = t;
    input_.append(bytes);
    process(t);
}

void TcpConnection::on_tick(Instant t) {
    forget_sent();
    if (!up_ || close_ != CloseReason::none) return;
    settle(t, framer_.on_tick(t));
    release(t);
    process(t);
    if (t >= frame_due()) close(CloseReason::frame_deadline);
    if (t >= idle_due()) close(CloseReason::idle_deadline);
}

Bytes TcpConnection::transmit(Instant t) {
    forget_sent();
    if (!up_) return {};
    release(t);
    process(t);
    out_sent_ = true;
    return out_.span();
}

Instant TcpConnection::next_wakeup() const {
    if (!up_ || close_ != CloseReason::none) return kNever;
    const Instant answer = waits_ == Waits::until_due ? due_ : kNever;
    return std::min({framer_.next_wakeup(), frame_due(), idle_due(), answer});
}

std::size_t TcpConnection::wants_bytes() const {
    return up_ && close_ == CloseReason::none ? kInput - input_.size() : 0;
}

bool TcpConnection::complete(Instant t, Token token, Bytes pdu) {
    if (waits_ != Waits::pending || token != token_) return false;
    forget_sent();
    pdu_.assign(pdu);
    waits_ = Waits::until_due;
    due_ = t;
    return true;
}

void TcpConnection::forget_sent() {
    if (out_sent_) out_.clear();
    out_sent_ = false;
}

void TcpConnection::process(Instant t) {
    std::size_t used = 0;
    const Bytes bytes = input_.span();
    while (used < bytes.size() && waits_ == Waits::no && close_ == CloseReason::none && room_for_answer()) {
        const wire::FramerStep step = framer_.push(t, bytes.subspan(used));
        used += step.consumed;
        if (step.consumed > 0 && frame_since_ == kNever) frame_since_ = t;
        settle(t, step);
    }
    if (close_ != CloseReason::none)
        input_.clear();
    else
        input_.drop_front(used);
}

void TcpConnection::settle(Instant t, const wire::FramerStep& step) {
    if (step.fault != wire::FrameFault::none) {
        counters_.count(step.fault);
        if (observer_) observer_->on_fault(t, step.fault);
        frame_since_ = kNever;
        if (step.fault == wire::FrameFault::bad_header) close(CloseReason::bad_header);
    }
    if (step.complete) {
        frame_since_ = kNever;
        take(t, framer_.frame());
    }
}

void TcpConnection::take(Instant t, const wire::Frame& frame) {
    if (observer_) observer_->on_frame(t, wire::Direction::received, frame.unit, frame.pdu, framer_.raw());
    ++counters_.requests;
    const Context context{t, frame.unit, false, config_.peer.view(), config_.role.view()};
    const Answer answer = responder_.handle(context, frame.pdu);
    if (answer.kind == Answer::Kind::silence) {
        ++counters_.unanswered;
        return;
    }
    waits_ = answer.kind == Answer::Kind::pending ? Waits::pending : Waits::until_due;
    due_ = after(t, answer.delay);
    token_ = answer.token;
    unit_ = frame.unit;
    transaction_ = frame.transaction;
    pdu_ = answer.pdu;
    release(t);
}

// There is room: a request is only looked at when its answer would fit.
void TcpConnection::release(Instant t) {
    if (waits_ != Waits::until_due || due_ > t) return;
    waits_ = Waits::no;
    const wire::FrameBytes frame = wire::encode_frame(config_.framing, unit_, transaction_, pdu_.span());
    out_.append(frame.span());
    ++counters_.answers;
    if ((pdu_[0] & 0x80) != 0) ++counters_.exceptions;
    if (observer_) observer_->on_frame(t, wire::Direction::sent, unit_, pdu_.span(), frame.span());
}

void TcpConnection::close(CloseReason reason) {
    if (close_ == CloseReason::none) close_ = reason;
}

Instant TcpConnection::frame_due() const {
    return frame_since_ == kNever ? kNever : deadline(frame_since_, config_.frame_deadline);
}

Instant TcpConnection::idle_due() const {
    return deadline(last_bytes_, config_.idle_deadline);
}

}  // namespace takt::serve
