// Sending: when a request may start. reception.cpp handles what is received.
#include "takt/bus/transaction_engine.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"
#include "takt/bus/failure_time.hpp"
#include "takt/wire/broadcast.hpp"
#include "takt/wire/silence.hpp"

namespace takt::bus {
namespace {

using namespace std::chrono_literals;
using wire::Framing;
using wire::Function;

constexpr Duration kAdapterSilence = 30ms;  // longer than the latency timer of USB adapters (16 ms)
constexpr Duration kStreamSilence = 50ms;
constexpr Duration kLeastBusyLimit = 1s;
// Why so long: docs/decisions/0032-in-step.md.
constexpr Duration kRemembered = 5min;      // how long a missing response is recognised
constexpr int kSuspicionFactor = 2;         // time-outs that requests wait after a response in doubt
constexpr Duration kLongestExpected = 30s;  // within which two responses in doubt do not prove a loss

// An adapter may deliver two frames together; the silence between them is then lost.
constexpr bool kFramesFollow = true;

Duration silence_inside_frame(const LineConfig& config) {
    if (config.frame_silence > Duration::zero()) return config.frame_silence;
    return config.is_serial() ? std::max(wire::t3_5(config.format), kAdapterSilence) : kStreamSilence;
}

wire::FramerConfig framer_config(const LineConfig& config) {
    wire::FramerConfig made{.framing = config.framing,
                            .side = wire::Side::master,
                            .silence = silence_inside_frame(config),
                            .character = config.characters_time(1)};
    made.length_tolerance = config.length_tolerance;
    if (config.frame_silence > Duration::zero()) made.ascii_pause = config.frame_silence;
    return made;
}

}  // namespace

TransactionCore::TransactionCore(const LineConfig& config, const TransactionStorage& storage,
                                 wire::TrafficObserver* observer)
    : config_(config),
      observer_(observer),
      framer_(framer_config(config), storage.receiving, kFramesFollow),
      echo_(config.framing == Framing::tcp ? Echo::absent : config.echo),
      outstanding_(storage.outstanding, storage.on_demand),
      slots_(storage.slots),
      longest_pdu_(storage.longest_pdu),
      outgoing_(storage.sending.first(TransactionStorage::sending_size(config.framing, storage.longest_pdu))),
      ids_(config.first_transaction),
      silence_(config.silence_before_request()),
      busy_limit_(silence_ + std::max(kLeastBusyLimit, 2 * config.characters_time(wire::kMaxAsciiFrame))),
      frame_silence_(silence_inside_frame(config)) {
    TAKT_ASSERT(!slots_.empty() && storage.pdus.size() >= slots_.size() * longest_pdu_);
    TAKT_ASSERT(numbered() || longest_pdu_ == wire::kMaxPdu);
    TAKT_ASSERT(numbered() || storage.on_demand || !storage.outstanding.empty());
    for (std::size_t i = 0; i < slots_.size(); ++i) slots_[i].pdu = &storage.pdus[i * longest_pdu_];
    config_.in_flight = config.framing == Framing::tcp && !config.length_tolerance
                            ? std::clamp<std::size_t>(config.in_flight, 1, slots_.size())
                            : 1;
}

std::size_t TransactionCore::occupied() const {
    return static_cast<std::size_t>(std::count_if(
        slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.state != State::empty; }));
}

bool TransactionCore::anything_sent() const {
    return std::any_of(slots_.begin(), slots_.end(), [](const Slot& slot) { return slot.in_flight(); });
}

std::size_t TransactionCore::responses_awaited() const {
    return static_cast<std::size_t>(std::ranges::count_if(slots_, &Slot::awaits_response));
}

std::optional<TransactionCore::Awaited> TransactionCore::awaited() const {
    const auto slot = std::ranges::find_if(slots_, &Slot::awaits_response);
    if (slot == slots_.end()) return std::nullopt;
    return Awaited{slot->id, slot->unit, slot->sent_at};
}

bool TransactionCore::can_submit() const {
    return link_up_ && occupied() < config_.in_flight;
}

bool TransactionCore::idle() const {
    return occupied() == 0;
}

// The framer is empty on both sides: a response that begins now is late, and is received from its start.
void TransactionCore::take_over(const TransactionCore& other) {
    TAKT_ASSERT(idle() && other.idle() && config_.framing == other.config_.framing);
    outstanding_.take_over(other.outstanding_);
    counters_ = other.counters_;
    ids_ = other.ids_;
    link_up_ = other.link_up_;
    must_reconnect_ = other.must_reconnect_;
    header_fault_ = other.header_fault_;
    rejected_ = other.rejected_;
    last_activity_ = other.last_activity_;
    activity_since_ = other.activity_since_;
    last_start_ = other.last_start_;
    blocked_until_ = other.blocked_until_;
}

Result<void> TransactionCore::submit(Instant t, const Transaction& transaction) {
    if (!link_up_) return fail(Code::connection_lost);
    if (!can_submit()) return fail(Code::queue_full, static_cast<std::int64_t>(config_.in_flight));
    if (transaction.request.empty()) return fail(Code::out_of_range, 0, 1, wire::kMaxPdu);
    if (transaction.request.size() > longest_pdu_)
        return fail(Code::too_long, static_cast<std::int64_t>(transaction.request.size()),
                    static_cast<std::int64_t>(longest_pdu_));
    const bool broadcast = config_.framing != Framing::tcp && transaction.unit == kBroadcast;
    const std::uint8_t function = transaction.request.function();
    if (broadcast && !wire::may_be_broadcast(Function{function})) return fail(Code::unsupported, function);

    auto& slot = *std::ranges::find(slots_, State::empty, &Slot::state);
    slot.state = State::waiting;
    slot.id = transaction.id;
    slot.unit = transaction.unit;
    slot.sent_once = false;
    slot.fill(transaction.request.pdu());
    slot.request = transaction.request.shape();
    slot.wait = transaction.wait;
    slot.late_limit = transaction.late_limit.value_or(transaction.wait);
    slot.lateness = transaction.lateness;
    slot.patience = transaction.patience;
    slot.longest_delay = std::min(transaction.longest_delay.value_or(slot.wait), slot.wait);
    slot.in_order = transaction.in_order;
    slot.broadcast = broadcast;
    slot.garbled = slot.unordered = slot.shared = false;
    slot.noise = 0;
    slot.instead.reset();
    slot.stray.reset();
    slot.submitted_at = t;
    slot.unit_busy_until = Instant::min();
    return {};
}

Instant TransactionCore::silence_end() const {
    return last_activity_ + silence_;
}

// A line is busy when it had no silence for longer than two of the longest frames.
Instant TransactionCore::busy_limit() const {
    return activity_since_ + busy_limit_;
}

Instant TransactionCore::earliest_start(UnitId unit, const AnswerShape& shape) const {
    const Instant quiet = std::min(silence_end(), busy_limit());
    const bool identified = numbered() || unit == kBroadcast;  // which has no response
    const Instant after_late_ones = identified ? Instant::min() : outstanding_.earliest(unit, shape);
    return std::max({quiet, last_start_ + config_.request_gap, blocked_until_, after_late_ones});
}

Ambiguity TransactionCore::ambiguity(Instant t, UnitId unit, const AnswerShape& shape) const {
    return numbered() ? Ambiguity::none : outstanding_.ambiguity(t, unit, shape);
}

Bytes TransactionCore::transmit(Instant t) {
    if (!link_up_) return {};
    const bool one_at_a_time = config_.framing != Framing::tcp;
    if (one_at_a_time && anything_sent()) return {};
    Slot* next = nullptr;
    for (auto& slot : slots_)
        if (slot.state == State::waiting && (!next || slot.submitted_at < next->submitted_at)) next = &slot;
    if (!next || t < silence_end() || t < earliest_start(next->unit, next->shape())) return {};
    return send(t, *next);
}

std::uint16_t TransactionCore::next_wire_id() {
    return ids_.next([&](std::uint16_t id) {
        return outstanding_.expects(id) || std::ranges::any_of(slots_, [id](const Slot& slot) {
                   return slot.in_flight() && easily_confused(id, slot.wire_id);
               });
    });
}

Bytes TransactionCore::send(Instant t, Slot& slot) {
    const UnitId unit = slot.unit;
    slot.wire_id = numbered() ? next_wire_id() : std::uint16_t{0};
    outgoing_.assign(wire::encode_frame(config_.framing, unit, slot.wire_id, slot.content()).span());
    const auto times = attempt_times(config_, slot.pdu_size, slot.request.response_length, slot.wait);
    const Instant request_end = t + times.request;
    slot.state = State::sent;
    slot.sent_once = true;
    slot.sent_at = t;
    slot.request_end = request_end;
    slot.deadline = request_end + (slot.broadcast ? config_.broadcast_turnaround : times.time_out());
    if (slot.broadcast) blocked_until_ = slot.deadline;
    if (config_.length_tolerance)
        framer_.expect_response(
            {.unit = unit, .function = slot.request.function, .transaction = slot.wire_id});
    last_start_ = t;
    noise_ = 0;
    if (config_.framing != Framing::tcp) {
        last_activity_ = request_end;
        activity_since_ = t;
        bytes_since_gap_ = 0;
        framer_.reset();
        if (!slot.broadcast)
            framer_.expect_response(
                {.unit = unit,
                 .function = slot.request.function,
                 .length = slot.request.fixed_length
                               ? wire::frame_length(config_.framing, slot.request.response_length)
                               : 0});
        const bool as_long = !slot.request.fixed_length || slot.request.response_length == slot.pdu_size;
        const bool repeats_itself =
            as_long && slot.request.decoded &&
            wire::decode_response(slot.request, slot.content(), slot.content()).has_value();
        echo_.arm(outgoing_.span(), repeats_itself, request_end + times.request);
    }
    if (observer_) observer_->on_frame(t, wire::Direction::sent, unit, slot.content(), outgoing_.span());
    return outgoing_.span();
}

Instant TransactionCore::next_wakeup() const {
    if (!link_up_) return kNever;
    Instant wakeup = framer_.next_wakeup();
    if (echo_.holding()) wakeup = std::min(wakeup, after(last_activity_, frame_silence_));
    const bool may_start = config_.framing == Framing::tcp || !anything_sent();
    for (const auto& slot : slots_) {
        if (slot.in_flight()) wakeup = std::min(wakeup, slot.deadline);
        if (slot.state == State::waiting && may_start)
            wakeup = std::min(wakeup, earliest_start(slot.unit, slot.shape()));
    }
    return wakeup;
}

void TransactionCore::on_link(Instant t, bool up) {
    if (up == link_up_) return;
    if (!up) return link_down(t, Status::link_lost);
    notify(t, UnitId{0}, wire::Incident::connected);
    link_up_ = true;
    bad_header_ = false;
    rejected_.clear();
    last_activity_ = activity_since_ = t;
    blocked_until_ = std::max(blocked_until_, t + config_.pause_after_connect);
    if (numbered()) outstanding_.clear();  // else a gateway may pass on what its serial line still sends
}

void TransactionCore::on_close(Instant t) {
    for (auto& slot : slots_)  // no further frame comes on this connection
        if (slot.state == State::confirming) conclude(t, slot);
    if (link_up_) link_down(t, must_reconnect_ ? Status::unexpected_reply : Status::closed);
}

void TransactionCore::link_down(Instant t, Status of_one_that_waits) {
    const Status status = responses_awaited() == 1 ? of_one_that_waits : Status::link_lost;
    for (auto& slot : slots_)
        if (slot.open()) give_up(t, slot, slot.awaits_response() ? status : Status::link_lost);
    link_up_ = must_reconnect_ = false;
    framer_.reset();
    bytes_since_gap_ = 0;
    notify(t, UnitId{0}, wire::Incident::disconnected);
}

void TransactionCore::notify(Instant t, UnitId unit, wire::Incident incident, Duration after,
                             const std::optional<Mismatch>& instead) {
    if (observer_) observer_->on_incident(t, unit, incident, after, instead);
}

void TransactionCore::cancel_all(Instant t) {
    for (auto& slot : slots_)
        if (slot.open()) give_up(t, slot, Status::cancelled);
}

void TransactionCore::give_up(Instant t, Slot& slot, Status status) {
    if (slot.in_flight() && !slot.broadcast)
        expect_response(t, slot, std::max(t, slot.deadline) + slot.late_limit);
    finish(t, slot, status);
    if (status == Status::timeout || slot.instead)
        notify(t, slot.unit, wire::Incident::no_response, slot.wait, slot.instead);
}

// A unit that does not keep the order is expected to answer late as long as it may take without being known.
Duration TransactionCore::expected_time(const Slot& slot) {
    const Duration least =
        slot.in_order ? Duration::zero() : OutstandingResponses::confirmation_time(slot.wait);
    return std::clamp<Duration>(kLatenessFactor * slot.lateness, least, std::max(least, kLongestExpected));
}

// Instant::min() where the response is not expected while requests that look alike wait.
Instant TransactionCore::patient_until(const Slot& slot, Instant hold_until) const {
    const Instant until = slot.request_end + slot.patience + config_.frame_time(slot.shape().pdu_length);
    return slot.patience > Duration::zero() && until <= hold_until ? until : Instant::min();
}

void TransactionCore::expect_response(Instant t, const Slot& slot, Instant hold_until) {
    const bool begun = !numbered() && slot.is_cut_short() && !echo_.may_come();
    if (begun) hold_until = t;
    outstanding_.add(
        {.unit = slot.unit,
         .wire_id = numbered() ? slot.wire_id : std::uint16_t{0},
         .in_order = slot.in_order,
         .misdirected = slot.instead && !slot.is_cut_short(),
         .begun = begun,
         .shape = slot.shape(),
         .end = std::max(slot.request_end, slot.unit_busy_until),
         .expired_at = t,
         .hold_until = hold_until,
         .patient_until = patient_until(slot, hold_until),
         .expected_until = t + expected_time(slot),
         .confirm_until = t + OutstandingResponses::confirmation_time(slot.wait),
         .forget_at = std::max(hold_until, t + kRemembered),
         .hold = hold_until > t ? std::max(kSuspicionFactor * slot.wait, slot.late_limit) : Duration::zero(),
         .wait = slot.wait});
}

// The response is copied out of the framer's buffer, which the next bytes overwrite.
void TransactionCore::finish(Instant t, Slot& slot, Status status, const wire::ResponseView& response) {
    const bool failed = status == Status::timeout || status == Status::unexpected_reply;
    slot.status = failed && slot.is_cut_short() ? Status::bad_checksum : status;
    if (!slot.explained()) slot.instead.reset();
    slot.out_of_step = must_reconnect_;
    slot.ended_at = t;
    if (!slot.sent_once) slot.sent_at = slot.request_end = t;
    slot.fill(response.pdu());
    slot.response = response.moved_to(slot.content());
    slot.quiet_at = quiet_at(t + slot.longest_delay, slot, slot.pdu_size);
    slot.noise = response.empty() ? 0 : static_cast<std::uint32_t>(noise_);
    if (slot.broadcast && status == Status::ok) ++counters_.broadcasts;
    if (!slot.sent_once) ++counters_.not_sent;
    slot.state = State::ended;
    slot.order = ++last_order_;
    counters_.count(outcome_of(slot));
}

Outcome TransactionCore::outcome_of(const Slot& slot) {
    return {.id = slot.id,
            .unit = slot.unit,
            .status = slot.status,
            .exception = slot.response.exception(),
            .sent = slot.sent_once,
            .out_of_step = slot.out_of_step,
            .wire_id = slot.wire_id,
            .instead = slot.instead,
            .noise = slot.noise,
            .request = slot.request,
            .wait = slot.wait,
            .response = slot.response,
            .sent_at = slot.sent_at,
            .request_end = slot.request_end,
            .ended_at = slot.ended_at,
            .quiet_at = slot.quiet_at};
}

std::optional<SurplusFrame> TransactionCore::take_surplus() {
    if (surplus_.empty()) return std::nullopt;
    const SurplusFrame first = surplus_[0];
    surplus_.drop_front(1);
    return first;
}

std::optional<Outcome> TransactionCore::take_outcome() {
    Slot* first = nullptr;
    for (auto& slot : slots_)
        if (slot.state == State::ended && (!first || slot.order < first->order)) first = &slot;
    if (!first) return std::nullopt;
    first->state = State::empty;
    return outcome_of(*first);
}

}  // namespace takt::bus
