// Sending: what may go out when. What comes back is judged in reception.cpp.
#include "takt/bus/transaction_engine.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"

namespace takt::bus {
namespace {

using namespace std::chrono_literals;
using wire::Framing;
using wire::Function;

constexpr Duration kLumpySilence = 30ms;
constexpr Duration kStreamSilence = 50ms;
constexpr Duration kLeastBusyLimit = 1s;

// Of the silence between two frames nothing is left where an adapter delivers both in one lump.
constexpr bool kFramesFollow = true;

bool may_be_broadcast(std::uint8_t function) {
    switch (Function{function}) {
        case Function::write_single_coil:
        case Function::write_single_register:
        case Function::write_multiple_coils:
        case Function::write_multiple_registers:
        case Function::write_file_record:
        case Function::mask_write_register: return true;
        default: return false;
    }
}

Duration silence_before_request(const LineConfig& config) {
    const bool t3_5 = config.framing == Framing::rtu && config.is_serial();
    return std::max(t3_5 ? wire::t3_5(config.format) : Duration::zero(), config.frame_gap);
}

Duration silence_inside_frame(const LineConfig& config) {
    if (config.frame_silence > Duration::zero()) return config.frame_silence;
    return config.is_serial() ? std::max(wire::t3_5(config.format), kLumpySilence) : kStreamSilence;
}

Duration characters_time(const LineConfig& config, std::size_t characters) {
    return config.is_serial() ? wire::transmission_time(config.format, characters) : Duration::zero();
}

// A device answers no sooner than after t3.5: a turnaround below it is that of its program.
Duration wait_for_first_byte(const LineConfig& config, Duration wait) {
    const bool t3_5 = config.framing == Framing::rtu && config.is_serial();
    return t3_5 ? std::max(wait, wire::t3_5(config.format)) : wait;
}

wire::FramerConfig framer_config(const LineConfig& config) {
    return {.framing = config.framing,
            .side = wire::Side::master,
            .silence = silence_inside_frame(config),
            .character = characters_time(config, 1)};
}

}  // namespace

TransactionEngine::TransactionEngine(const LineConfig& config, wire::TrafficObserver* observer)
    : config_(config),
      observer_(observer),
      framer_(framer_config(config), kFramesFollow),
      echo_(config.framing == Framing::tcp ? Echo::absent : config.echo),
      silence_(silence_before_request(config)),
      frame_silence_(silence_inside_frame(config)) {
    config_.in_flight =
        config.framing == Framing::tcp ? std::clamp<std::size_t>(config.in_flight, 1, kMaxInFlight) : 1;
}

std::size_t TransactionEngine::occupied() const {
    return static_cast<std::size_t>(std::count_if(
        slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.state != State::empty; }));
}

bool TransactionEngine::anything_sent() const {
    return std::any_of(slots_.begin(), slots_.end(),
                       [](const Slot& slot) { return slot.state == State::sent; });
}

bool TransactionEngine::can_submit() const {
    const std::size_t taken = occupied();
    return link_up_ && taken < config_.in_flight &&
           taken + outcomes_.size() < decltype(outcomes_)::capacity();
}

bool TransactionEngine::idle() const {
    return occupied() == 0 && outcomes_.empty();
}

Result<void> TransactionEngine::submit(Instant t, const Transaction& transaction) {
    if (!link_up_) return fail(Code::connection_lost);
    if (!can_submit()) return fail(Code::queue_full, static_cast<std::int64_t>(config_.in_flight));
    if (transaction.request.empty()) return fail(Code::out_of_range, 0, 1, wire::kMaxPdu);
    const bool broadcast = config_.framing != Framing::tcp && transaction.unit == kBroadcast;
    const std::uint8_t function = transaction.request[0];
    if (broadcast && !may_be_broadcast(function)) return fail(Code::unsupported, function);

    auto* slot =
        std::find_if(slots_.begin(), slots_.end(), [](const Slot& s) { return s.state == State::empty; });
    slot->state = State::waiting;
    slot->transaction = transaction;
    slot->request.reset();
    if (auto request = wire::decode_request(transaction.request.span())) slot->request = *request;
    slot->shape = answer_shape(transaction.request.span());
    slot->broadcast = broadcast;
    slot->garbled = false;
    slot->submitted_at = t;
    return {};
}

Instant TransactionEngine::silence_end() const {
    return last_activity_ + silence_;
}

// A line that never falls silent: twice the longest frame is more than one station can have to say.
Instant TransactionEngine::busy_limit() const {
    return activity_since_ + silence_ +
           std::max(kLeastBusyLimit, 2 * characters_time(config_, wire::kMaxAsciiFrame));
}

Instant TransactionEngine::earliest_start(UnitId unit, const AnswerShape& shape) const {
    const Instant quiet = std::min(silence_end(), busy_limit());
    return std::max({quiet, last_start_ + config_.request_gap, blocked_until_, late_.earliest(unit, shape)});
}

Bytes TransactionEngine::transmit(Instant t) {
    if (!link_up_) return {};
    const bool one_at_a_time = config_.framing != Framing::tcp;
    if (one_at_a_time && anything_sent()) return {};
    Slot* next = nullptr;
    for (auto& slot : slots_)
        if (slot.state == State::waiting && (!next || slot.submitted_at < next->submitted_at)) next = &slot;
    if (!next || t < silence_end() || t < earliest_start(next->transaction.unit, next->shape)) return {};
    return send(t, *next);
}

Bytes TransactionEngine::send(Instant t, Slot& slot) {
    slot.wire_id = ++next_wire_id_;
    outgoing_ = wire::encode_frame(config_.framing, slot.transaction.unit, slot.wire_id,
                                   slot.transaction.request.span());
    slot.state = State::sent;
    slot.sent_at = t;
    slot.request_end = t + characters_time(config_, outgoing_.size());
    slot.deadline = slot.broadcast ? slot.request_end + config_.broadcast_turnaround
                                   : slot.request_end + wait_for_first_byte(config_, slot.transaction.wait) +
                                         response_time(slot) + config_.margin;
    if (slot.broadcast) blocked_until_ = slot.deadline;
    last_start_ = t;
    if (config_.framing != Framing::tcp) {
        last_activity_ = slot.request_end;
        activity_since_ = t;
        lump_ = 0;
        framer_.reset();
        const Bytes pdu = slot.transaction.request.span();
        const bool repeats_itself = slot.request && wire::decode_response(*slot.request, pdu).has_value();
        echo_.arm(outgoing_.span(), repeats_itself,
                  slot.request_end + characters_time(config_, outgoing_.size()));
    }
    if (observer_)
        observer_->on_frame(t, wire::Direction::sent, slot.transaction.unit, slot.transaction.request.span(),
                            outgoing_.span());
    return outgoing_.span();
}

Duration TransactionEngine::response_time(const Slot& slot) const {
    const std::size_t length = slot.request ? wire::max_response_length(*slot.request) : wire::kMaxPdu;
    return characters_time(config_, wire::frame_length(config_.framing, length));
}

Instant TransactionEngine::next_wakeup() const {
    if (!link_up_) return kNever;
    Instant wakeup = framer_.next_wakeup();
    if (echo_.holding()) wakeup = std::min(wakeup, after(last_activity_, frame_silence_));
    const bool may_start = config_.framing == Framing::tcp || !anything_sent();
    for (const auto& slot : slots_) {
        if (slot.state == State::sent) wakeup = std::min(wakeup, slot.deadline);
        if (slot.state == State::waiting && may_start)
            wakeup = std::min(wakeup, earliest_start(slot.transaction.unit, slot.shape));
    }
    return wakeup;
}

void TransactionEngine::on_link(Instant t, bool up) {
    if (up == link_up_) return;
    link_up_ = up;
    framer_.reset();
    lump_ = 0;
    must_reconnect_ = false;
    if (up) {
        last_activity_ = activity_since_ = t;
        if (!config_.is_serial()) late_.clear();  // a new connection brings nothing of the old one
        return;
    }
    for (auto& slot : slots_)
        if (slot.state != State::empty) give_up(t, slot, Status::link_lost);
}

void TransactionEngine::cancel_all(Instant t) {
    for (auto& slot : slots_)
        if (slot.state != State::empty) give_up(t, slot, Status::cancelled);
}

void TransactionEngine::give_up(Instant t, Slot& slot, Status status) {
    if (slot.state == State::sent && !slot.broadcast && config_.framing != Framing::tcp) {
        const Duration limit = slot.transaction.late_limit.value_or(slot.transaction.wait);
        late_.expect(slot.transaction.unit, slot.shape, std::max(t, slot.deadline) + limit);
    }
    finish(t, slot, status);
}

void TransactionEngine::finish(Instant t, Slot& slot, Status status, Bytes response, std::uint8_t exception) {
    const bool sent = slot.state == State::sent;
    Outcome outcome{.id = slot.transaction.id,
                    .unit = slot.transaction.unit,
                    .status = status,
                    .exception = exception,
                    .sent = sent,
                    .sent_at = sent ? slot.sent_at : t,
                    .request_end = sent ? slot.request_end : t,
                    .ended_at = t};
    outcome.response.assign(response);
    if (slot.broadcast && status == Status::ok) ++counters_.broadcasts;
    if (!sent) ++counters_.not_sent;
    counters_.count(outcome);
    slot.state = State::empty;
    const bool kept = outcomes_.try_push(outcome);
    TAKT_ASSERT(kept);
}

std::optional<Outcome> TransactionEngine::take_outcome() {
    if (outcomes_.empty()) return std::nullopt;
    return outcomes_.pop();
}

}  // namespace takt::bus
