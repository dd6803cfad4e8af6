// Flow control. Received bytes wait in the input buffer; a frame is parsed only if the output buffer has
// space for the largest answer and no earlier answer is pending. So answers keep the order of their requests,
// and a peer that does not read its answers is not read either. Deadlines: frame_deadline from the first byte
// of an incomplete frame, idle_deadline from the last byte.
#include "takt/serve/tcp_connection.hpp"

#include <algorithm>

namespace takt::serve {
namespace {

wire::FramerConfig tcp_framer_config(const TcpConfig& config) {
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

TcpConnectionCore::TcpConnectionCore(const TcpConfig& config, Responder& responder, TcpBufferPool& pool,
                                     std::span<std::uint8_t> framer_storage, wire::TrafficObserver* observer)
    : responder_(responder),
      observer_(observer),
      config_(config),
      pool_(pool),
      framer_(tcp_framer_config(config), framer_storage, true) {}

TcpConnectionCore::~TcpConnectionCore() {
    if (buffers_) pool_.release(*buffers_);
}

void TcpConnectionCore::acquire_buffers() {
    if (!buffers_) buffers_ = &pool_.acquire();
}

void TcpConnectionCore::release_buffers() {
    if (!buffers_ || input_size_ > 0 || output_size_ > 0) return;
    pool_.release(*buffers_);
    buffers_ = nullptr;
}

void TcpConnectionCore::on_link(Instant t, bool up) {
    up_ = up;
    if (up) close_ = CloseReason::none;
    last_bytes_ = t;
    frame_since_ = kNever;
    framer_.reset();
    input_size_ = 0;
    output_size_ = 0;
    output_sent_ = false;
    release_buffers();
    if (waits_ != Waits::no) ++counters_.unanswered;
    waits_ = Waits::no;
}

void TcpConnectionCore::on_bytes(Instant t, Bytes bytes) {
    forget_sent();
    if (!up_ || close_ != CloseReason::none || bytes.empty()) return;
    if (bytes.size() > wants_bytes()) {
        close(CloseReason::too_much);
        return;
    }
    last_bytes_ = t;
    acquire_buffers();
    std::ranges::copy(bytes, buffers_->input.begin() + static_cast<std::ptrdiff_t>(input_size_));
    input_size_ += bytes.size();
    process(t);
}

void TcpConnectionCore::on_tick(Instant t) {
    forget_sent();
    if (!up_ || close_ != CloseReason::none) return;
    settle(t, framer_.on_tick(t));
    release(t);
    process(t);
    if (t >= frame_due()) close(CloseReason::frame_deadline);
    if (t >= idle_due()) close(CloseReason::idle_deadline);
}

Bytes TcpConnectionCore::transmit(Instant t) {
    forget_sent();
    if (!up_) return {};
    release(t);
    process(t);
    output_sent_ = true;
    release_buffers();
    return buffers_ ? Bytes(buffers_->output).first(output_size_) : Bytes();
}

Instant TcpConnectionCore::next_wakeup() const {
    if (!up_ || close_ != CloseReason::none) return kNever;
    const Instant answer = waits_ == Waits::until_due ? due_ : kNever;
    return std::min({framer_.next_wakeup(), frame_due(), idle_due(), answer});
}

std::size_t TcpConnectionCore::wants_bytes() const {
    return up_ && close_ == CloseReason::none ? pool_.input_size() - input_size_ : 0;
}

bool TcpConnectionCore::complete(Instant t, Token token, Bytes pdu) {
    if (waits_ != Waits::pending || token != token_) return false;
    forget_sent();
    pdu_.assign(pdu);
    waits_ = Waits::until_due;
    due_ = t;
    return true;
}

void TcpConnectionCore::forget_sent() {
    if (output_sent_) output_size_ = 0;
    output_sent_ = false;
}

void TcpConnectionCore::process(Instant t) {
    if (input_size_ == 0) return;
    std::size_t used = 0;
    const Bytes bytes = Bytes(buffers_->input).first(input_size_);
    while (used < bytes.size() && waits_ == Waits::no && close_ == CloseReason::none && room_for_answer()) {
        const wire::FramerStep step = framer_.push(t, bytes.subspan(used));
        used += step.consumed;
        if (step.consumed > 0 && frame_since_ == kNever) frame_since_ = t;
        settle(t, step);
    }
    if (close_ != CloseReason::none) used = input_size_;
    std::ranges::copy(bytes.subspan(used), buffers_->input.begin());
    input_size_ -= used;
}

template <class Call>
void TcpConnectionCore::observe(Call call) {
    if (!observer_) return;
    observer_->on_peer(config_.peer.view());
    call(*observer_);
}

void TcpConnectionCore::settle(Instant t, const wire::FramerStep& step) {
    if (step.fault != wire::FrameFault::none) {
        counters_.count(step.fault);
        responder_.on_line_event(LineEvent::error);
        observe([&](auto& observer) { observer.on_fault(t, step.fault, framer_.dropped()); });
        frame_since_ = kNever;
        if (step.fault == wire::FrameFault::bad_header) close(CloseReason::bad_header);
    }
    if (step.complete) {
        frame_since_ = kNever;
        take(t, framer_.frame());
    }
}

void TcpConnectionCore::take(Instant t, const wire::Frame& frame) {
    observe([&](auto& observer) {
        observer.on_frame(t, wire::Direction::received, frame.unit, frame.pdu, framer_.raw());
    });
    ++counters_.requests;
    responder_.on_line_event(LineEvent::message);
    const Context context{t, frame.unit, false, config_.peer.view(), config_.role.view()};
    const Answer answer = responder_.handle(context, wire::RequestView(frame.pdu));
    if (answer.kind == Answer::Kind::silence) {
        ++counters_.unanswered;
        return;
    }
    if (answer.kind == Answer::Kind::response && answer.delay <= Duration::zero())
        return this->answer(t, frame.unit, frame.transaction, answer.pdu.span());
    waits_ = answer.kind == Answer::Kind::pending ? Waits::pending : Waits::until_due;
    due_ = after(t, answer.delay);
    token_ = answer.token;
    unit_ = frame.unit;
    transaction_ = frame.transaction;
    pdu_ = answer.pdu;
}

void TcpConnectionCore::release(Instant t) {
    if (waits_ != Waits::until_due || due_ > t) return;
    waits_ = Waits::no;
    answer(t, unit_, transaction_, pdu_.span());
}

// A request is parsed only while its largest response fits into the output buffer.
void TcpConnectionCore::answer(Instant t, UnitId unit, std::uint16_t transaction, Bytes pdu) {
    const wire::FrameBytes frame = wire::encode_frame(config_.framing, unit, transaction, pdu);
    acquire_buffers();
    std::ranges::copy(frame.span(), buffers_->output.begin() + static_cast<std::ptrdiff_t>(output_size_));
    output_size_ += frame.size();
    ++counters_.answers;
    if (wire::is_exception(pdu[0])) ++counters_.exceptions;
    observe([&](auto& observer) { observer.on_frame(t, wire::Direction::sent, unit, pdu, frame.span()); });
}

void TcpConnectionCore::close(CloseReason reason) {
    if (close_ == CloseReason::none) close_ = reason;
}

Instant TcpConnectionCore::frame_due() const {
    return frame_since_ == kNever ? kNever : deadline(frame_since_, config_.frame_deadline);
}

Instant TcpConnectionCore::idle_due() const {
    return deadline(last_bytes_, config_.idle_deadline);
}

}  // namespace takt::serve
