#include "takt/publish/mqtt_session.hpp"

#include <algorithm>
#include <deque>
#include <utility>

#include "mqtt/broker_choice.hpp"
#include "mqtt/mqtt_packet.hpp"
#include "mqtt/mqtt_session_state.hpp"
#include "outputs/live_queue.hpp"
#include "outputs/source_window.hpp"

namespace takt::publish {

MqttSession::State::State(MqttSessionOptions the_options, MessageSource& the_source,
                          MqttListener& the_listener)
    : options(std::move(the_options)),
      source(the_source),
      listener(the_listener),
      choice(options),
      window(source),
      live(options.live_queue),
      pause(options.first_pause) {
    allowed = options.window;
}

// The phases. Each change of the state that a user sees goes through here.
void MqttSession::State::enter(Instant now, Phase next) {
    const MqttState before = shown();
    phase = next;
    if (shown() != before) since = now;
}

MqttState MqttSession::State::shown() const {
    switch (phase) {
        case Phase::off: return MqttState::off;
        case Phase::waiting: return taken_over ? MqttState::stopped : MqttState::backing_off;
        case Phase::connecting:
        case Phase::subscribing: return MqttState::connecting;
        case Phase::online: return MqttState::connected;
        case Phase::draining:
        case Phase::farewell: return MqttState::leaving;
        case Phase::closing: break;
    }
    return stopping ? MqttState::leaving : MqttState::connecting;
}

void MqttSession::State::connect(Instant now) {
    taken_over = false;
    deadline = after(now, options.connect_timeout);
    pending_failure.reset();
    ++counters.attempts;
    ++connection;
    actions.clear();
    actions.emplace_back(MqttConnect{.connection = connection,
                                     .broker = options.brokers[choice.index()],
                                     .version = choice.version(),
                                     .client_id = options.client_id,
                                     .user = options.user,
                                     .password = options.password,
                                     .keep_alive = options.keep_alive,
                                     .will = choice.will()});
    enter(now, Phase::connecting);
}

void MqttSession::State::wait(Instant now, Duration pause_length) {
    if (pause_length == Duration::zero()) return connect(now);
    deadline = after(now, pause_length);
    enter(now, Phase::waiting);
}

// Ends the connection; the rest follows on MqttClosed. A failure is the session's own, not the pipe's.
void MqttSession::State::close(Instant now, std::optional<MqttFailure> failure) {
    actions.emplace_back(MqttDisconnect{.connection = connection, .orderly = !failure});
    pending_failure = std::move(failure);
    deadline = kNever;
    enter(now, Phase::closing);
}

void MqttSession::State::note(Instant now, Concern concern, MqttFailure failure) {
    failures[static_cast<std::size_t>(concern)] = failure;
    last_failure = std::move(failure);
    last_failure_at = now;
}

std::optional<MqttFailure> MqttSession::State::failure() const {
    const auto found =
        std::ranges::find_if(failures, [](const auto& failure) { return failure.has_value(); });
    return found == failures.end() ? std::nullopt : *found;
}

void MqttSession::State::on(Instant now, const MqttConnected& event) {
    if (phase != Phase::connecting) return;
    ++counters.connects;
    choice.on_connected(now);
    connected = event;
    version = choice.version();
    subscribed = options.subscriptions.empty();
    blocked_until = kNotBlocked;
    progress = now;
    deadline = after(now, options.answer_timeout);
    if (options.subscriptions.empty()) return go_online(now);
    subscribe_token = ++last_token;
    actions.emplace_back(MqttSubscribe{connection, subscribe_token, options.subscriptions});
    enter(now, Phase::subscribing);
}

void MqttSession::State::on(Instant now, MqttSubscribed&& event) {
    if (phase != Phase::subscribing || event.token != subscribe_token) return;
    const auto refused = std::ranges::find_if(event.reasons, is_failure);
    subscribed = refused == event.reasons.end();
    if (!subscribed) note(now, Concern::subscription, {failure_kind(*refused), *refused, "SUBACK"});
    go_online(now);
}

void MqttSession::State::go_online(Instant now) {
    deadline = kNever;
    succeeded(Concern::connection);
    if (subscribed) succeeded(Concern::subscription);
    enter(now, Phase::online);
    if (options.birth) live.push_front({.message = *options.birth, .this_connection_only = true});
    listened = true;
    listener.on_connected(now, connection);
}

void MqttSession::State::on(Instant now, const MqttAcknowledged& event) {
    if (is_due_first(event.token)) progress = now;
    if (phase == Phase::farewell && event.token == farewell_token) return close(now, {});
    if (on_live_settled(now, event)) return;
    switch (window.settle(now, event.token, event.reason)) {
        case SourceWindow::Settled::not_found: return;
        case SourceWindow::Settled::accepted:
            speed_up();
            ++counters.acknowledged;
            if (event.reason == MqttReason::no_matching_subscribers) ++counters.no_subscribers;
            break;
        case SourceWindow::Settled::handed_over:
            speed_up();
            ++counters.unproved;
            break;
        case SourceWindow::Settled::rejected: ++counters.rejected; break;
        case SourceWindow::Settled::refused:
            ++counters.refused;
            note(now, Concern::message, {failure_kind(event.reason), event.reason, "PUBACK"});
            slow_down(now);
            break;
    }
    if (window.blocked() && window.waiting() == 0) window.rewind();
    if (phase == Phase::draining) on_drained(now);
}

bool MqttSession::State::on_live_settled(Instant now, const MqttAcknowledged& event) {
    const auto settled = live.settle(event.token, event.reason);
    switch (settled) {
        case LiveQueue::Settled::not_found: return false;
        case LiveQueue::Settled::accepted: ++counters.live_published; break;
        case LiveQueue::Settled::dropped: ++counters.live_dropped; break;
        case LiveQueue::Settled::refused: slow_down(now); break;
    }
    if (settled == LiveQueue::Settled::accepted)
        succeeded(Concern::live);
    else
        note(now, Concern::live, {failure_kind(event.reason), event.reason, "PUBACK"});
    if (phase == Phase::draining) on_drained(now);
    return true;
}

// The window begins with one message again, after a pause that doubles with each refusal without a success.
void MqttSession::State::slow_down(Instant now) {
    allowed = 1;
    if (blocked_until > now) return;
    blocked_until = after(now, pause);
    pause = std::min(2 * pause, options.longest_pause);
}

// Answers to messages that were sent before the refused one is sent again prove nothing.
void MqttSession::State::speed_up() {
    if (window.blocked()) return;
    succeeded(Concern::message);
    allowed = std::min(allowed + 1, options.window);
    pause = options.first_pause;
}

void MqttSession::State::on(Instant now, MqttReceived&& event) {
    ++counters.received;
    // A command must not be executed if its outcome could not be published any more.
    if (phase == Phase::closing || stopping) return;
    listener.on_message(now,
                        {connection, subscribed && phase != Phase::subscribing, std::move(event.message)});
}

void MqttSession::State::on(Instant, MqttOversized&& event) {
    ++counters.oversized;
    last_oversized = std::move(event);
}

void MqttSession::State::on(Instant now, const MqttClosed& event) {
    const bool was_open = version.has_value();
    const bool was_left = phase == Phase::closing && !pending_failure;
    const auto failure = pending_failure ? *std::exchange(pending_failure, {}) : event.failure;
    forget_connection(now);
    if (stopping) {
        stopping = false;
        deadline = kNever;
        return enter(now, Phase::off);
    }
    if (was_left) {
        choice.on_left();
        return connect(now);
    }
    note(now, Concern::connection, failure);
    if (!was_open) return wait(now, choice.on_failed(failure, event.nearby));
    ++counters.lost_connections;
    taken_over = failure.kind == MqttFailureKind::session_taken_over;
    if (failure.kind == MqttFailureKind::quota) allowed = 1;
    wait(now, choice.on_lost(now, failure));
}

void MqttSession::State::forget_connection(Instant now) {
    actions.clear();
    version.reset();
    subscribed = false;
    window.rewind();
    counters.live_dropped += live.on_lost();
    if (std::exchange(listened, false)) listener.on_disconnected(now, connection);
}

void MqttSession::State::leave(Instant now, Duration limit) {
    deadline = after(now, limit);
    enter(now, Phase::draining);
    on_drained(now);
}

// Publishes the will as soon as nothing is in flight: the broker drops it on an orderly end.
void MqttSession::State::on_drained(Instant now) {
    if (in_flight() > 0) return;
    if (!options.will) return close(now, {});
    farewell_token = ++last_token;
    actions.emplace_back(MqttPublish{connection, farewell_token, adapted(*options.will)});
    progress = now;
    enter(now, Phase::farewell);
}

void MqttSession::State::on_deadline(Instant now) {
    switch (phase) {
        case Phase::off:
        case Phase::closing:
        case Phase::online: break;
        case Phase::waiting: connect(now); break;
        case Phase::connecting: close(now, MqttFailure{MqttFailureKind::timed_out, {}, "CONNECT"}); break;
        case Phase::subscribing: close(now, MqttFailure{MqttFailureKind::timed_out, {}, "SUBSCRIBE"}); break;
        case Phase::draining:
        case Phase::farewell: close(now, {}); break;
    }
}

// A broker acknowledges in the order of the messages (MQTT 5.0, 4.6). While it answers later ones only, the
// first answer is lost, and so is the progress of the source.
bool MqttSession::State::is_due_first(MqttToken token) const {
    const MqttToken of_source = window.oldest_waiting();
    const MqttToken of_live = live.oldest_in_flight();
    const bool source_first = of_live == 0 || (of_source != 0 && of_source < of_live);
    return token == (source_first ? of_source : of_live);
}

Instant MqttSession::State::answer_deadline() const {
    if (phase != Phase::online || in_flight() == 0) return kNever;
    return after(progress, options.answer_timeout);
}

Instant MqttSession::State::return_deadline() const {
    return phase == Phase::online ? choice.return_at() : kNever;
}

MqttMessage MqttSession::State::adapted(MqttMessage message) const {
    message.qos = std::min(message.qos, connected.maximum_qos);
    message.retain = message.retain && connected.retain_available;
    return message;
}

std::size_t MqttSession::State::window_now() const {
    return std::min<std::size_t>(allowed, connected.receive_maximum);
}

std::size_t MqttSession::State::packet_limit() const {
    return connected.maximum_packet ? *connected.maximum_packet : kNoPacketLimit;
}

std::optional<MqttAction> MqttSession::State::publish_action(Instant now, MqttMessage&& message) {
    if (in_flight() == 1) progress = now;
    return MqttPublish{connection, last_token, adapted(std::move(message))};
}

std::optional<MqttAction> MqttSession::State::next_live(Instant now) {
    counters.live_dropped += live.drop_expired(now);
    while (const MqttMessage* message = live.next()) {
        const auto reason = reason_not_to_send(*message, *version, packet_limit());
        if (reason == MqttReason::success) {
            live.sent(++last_token);
            return publish_action(now, MqttMessage(*message));
        }
        if (reason == MqttReason::packet_too_large && live.shorten_next()) continue;
        live.drop_next();
        ++counters.live_dropped;
    }
    return {};
}

std::optional<MqttAction> MqttSession::State::next_of_source(Instant now) {
    while (!window.blocked() && window.size() < options.window) {
        auto next = source.next(now, {*version, packet_limit()});
        if (!next) return {};
        const MqttToken token = ++last_token;
        const auto reason = reason_not_to_send(next->message, *version, packet_limit());
        if (reason != MqttReason::success) {
            ++counters.rejected;
            window.unsendable(now, token, next->token, reason);
            continue;
        }
        window.sent(now, token, next->token, std::min(next->message.qos, connected.maximum_qos) > 0);
        ++counters.published;
        if (next->repeated) ++counters.repeated;
        return publish_action(now, std::move(next->message));
    }
    return {};
}

std::optional<MqttAction> MqttSession::State::next_action(Instant now) {
    if (!actions.empty()) {
        auto action = std::move(actions.front());
        actions.pop_front();
        return action;
    }
    if (phase != Phase::online || now < blocked_until || in_flight() >= window_now()) return {};
    if (auto action = next_live(now)) return action;
    return next_of_source(now);
}

MqttSession::MqttSession(MqttSessionOptions options, MessageSource& source, MqttListener& listener)
    : state_(std::make_unique<State>(std::move(options), source, listener)) {}
MqttSession::MqttSession(MqttSession&&) noexcept = default;
MqttSession& MqttSession::operator=(MqttSession&&) noexcept = default;
MqttSession::~MqttSession() = default;

void MqttSession::start(Instant now) {
    if (state_->phase == State::Phase::off) state_->connect(now);
}

void MqttSession::stop(Instant now) {
    State& state = *state_;
    if (state.phase == State::Phase::off || std::exchange(state.stopping, true)) return;
    switch (state.phase) {
        case State::Phase::off:
        case State::Phase::closing: break;
        case State::Phase::waiting:
            state.stopping = false;
            state.deadline = kNever;
            state.enter(now, State::Phase::off);
            break;
        case State::Phase::connecting:
        case State::Phase::subscribing: state.close(now, {}); break;
        case State::Phase::online: state.leave(now, state.options.leave_timeout); break;
        case State::Phase::draining:
        case State::Phase::farewell:
            state.deadline = std::min(state.deadline, after(now, state.options.leave_timeout));
            break;
    }
}

void MqttSession::on_event(Instant now, MqttEvent&& event) {
    std::visit(
        [&](auto&& its) {
            if (its.connection == state_->connection && state_->is_expecting())
                state_->on(now, std::forward<decltype(its)>(its));
        },
        std::move(event));
}

void MqttSession::on_tick(Instant now) {
    State& state = *state_;
    if (now >= state.blocked_until) state.blocked_until = kNotBlocked;
    if (now >= state.deadline) return state.on_deadline(now);
    if (now >= state.answer_deadline())
        return state.close(now, MqttFailure{MqttFailureKind::timed_out, {}, "PUBACK"});
    if (now >= state.return_deadline()) state.leave(now, state.options.answer_timeout);
}

Instant MqttSession::next_wakeup() const {
    const State& state = *state_;
    const Instant wakeup = std::min({state.deadline, state.answer_deadline(), state.return_deadline()});
    return state.blocked_until == kNotBlocked ? wakeup : std::min(wakeup, state.blocked_until);
}

std::optional<MqttAction> MqttSession::next_action(Instant now) {
    return state_->next_action(now);
}

bool MqttSession::publish(Instant now, LiveMessage&& live) {
    State& state = *state_;
    const bool connected = state.phase == State::Phase::subscribing || state.phase == State::Phase::online;
    const bool sendable =
        is_topic_name(live.message.topic) && live.expires > now && (connected || !live.this_connection_only);
    if (sendable && state.live.push(std::move(live))) return true;
    ++state.counters.live_dropped;
    return false;
}

MqttStatus MqttSession::status() const {
    const State& state = *state_;
    MqttStatus status{
        .state = state.shown(),
        .since = state.since,
        .broker = state.choice.index(),
        .version = state.version,
        .subscribed = state.subscribed && state.phase != State::Phase::subscribing,
        .refusing = state.failures[static_cast<std::size_t>(State::Concern::message)].has_value(),
        .failure = state.failure(),
        .last_failure = state.last_failure,
        .last_failure_at = state.last_failure_at,
        .last_oversized = state.last_oversized,
        .counters = state.counters};
    if (state.phase == State::Phase::waiting) status.next_attempt = state.deadline;
    status.live_waiting = state.live.size();
    if (!state.version) return status;
    status.qos_0_only = state.qos_0_only();
    status.retain_unavailable = !state.connected.retain_available;
    status.maximum_packet = state.connected.maximum_packet;
    status.keep_alive = state.connected.server_keep_alive
                            ? std::chrono::seconds(*state.connected.server_keep_alive)
                            : state.options.keep_alive;
    status.window = state.window_now();
    status.round_trip = state.window.round_trip();
    status.in_flight = state.in_flight();
    return status;
}

}  // namespace takt::publish
