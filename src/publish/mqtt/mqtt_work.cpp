#include "takt/publish/mqtt_work.hpp"

#include <algorithm>
#include <utility>

#include "takt/base/assert.hpp"
#include "takt/publish/message_format.hpp"

namespace takt::publish {
namespace {

OutputState state_of(const MqttStatus& status) {
    switch (status.state) {
        case MqttState::off: return OutputState::ended;
        case MqttState::connecting: return OutputState::connecting;
        case MqttState::connected:
        case MqttState::leaving: return status.refusing ? OutputState::waiting : OutputState::delivering;
        case MqttState::backing_off: return OutputState::waiting;
        case MqttState::stopped: return OutputState::stopped;
    }
    return OutputState::ended;
}

std::string url_of(const MqttBroker& broker) {
    const bool ipv6 = broker.host.find(':') != std::string::npos;
    return std::string(broker.tls ? "mqtts://" : "mqtt://") + (ipv6 ? "[" + broker.host + "]" : broker.host) +
           ":" + std::to_string(broker.port);
}

std::string failure_text(const MqttFailure& failure) {
    std::string text(name(failure.kind));
    if (failure.reason != MqttReason::success && name(failure.reason) != text)
        text += ", " + std::string(name(failure.reason));
    if (!failure.text.empty()) text += ": " + failure.text;
    return text;
}

}  // namespace

MqttWork::MqttWork(Options options)
    : options_(std::move(options)), descriptors_{options_.pipe->descriptor()} {
    if (options_.commands) descriptors_.push_back(options_.host->descriptor());
}

MqttWork::~MqttWork() = default;

void MqttWork::begin(Instant now, store::Journal& journal, store::DestinationId destination) {
    messages_.emplace(journal, destination, *options_.composer);
    session_.emplace(MqttSession(options_.session, *messages_, *this));
    session_->start(now);
}

void MqttWork::work(Instant now) {
    TAKT_ASSERT(session_);
    while (auto event = options_.pipe->next_event()) session_->on_event(now, *std::move(event));
    if (session_->next_wakeup() <= now) session_->on_tick(now);
    if (options_.commands) execute_commands(now);
    if (status_at_ <= now) publish_status(now);
    while (auto action = session_->next_action(now)) options_.pipe->send(*std::move(action));
}

CommandTime MqttWork::in_both_clocks(Instant now) const {
    return {now, options_.wall_ns(now)};
}

Instant MqttWork::next_wakeup() const {
    return session_ ? std::min(session_->next_wakeup(), status_at_) : kNever;
}

void MqttWork::on_state_changed(Instant now) {
    if (status_at_ == kNever) return;  // not connected: published at the next connection
    status_at_ = std::min(status_at_, std::max(now, status_sent_at_ + kStatusGap));
}

void MqttWork::publish_status(Instant now) {
    status_sent_at_ = now;
    status_at_ = now + kStatusEvery;
    const auto snapshot = options_.host->snapshot({.values = false, .statistics = true}, kStatusGap);
    if (!snapshot) return;
    MqttMessage message{.topic = options_.status_topic,
                        .payload = status_message(*snapshot, options_.wall_ns(snapshot->t))};
    message.retain = true;
    message.properties.content_type = "application/json";
    // A full queue is counted by the session; the next status replaces this one.
    static_cast<void>(session_->publish(now, {.message = std::move(message), .this_connection_only = true}));
}

void MqttWork::execute_commands(Instant now) {
    auto& desk = options_.commands->desk;
    const auto time = in_both_clocks(now);
    (void)options_.host->rearm();
    while (const auto command = desk.next_command(time)) {
        const auto submitted = options_.host->submit(*command);
        if (!submitted) desk.on_rejected(time, command->tag, submitted.error());
    }
    while (const auto outcome = options_.host->next_outcome()) desk.on_outcome(time, *outcome);
    publish_answers(now);
}

// The queue of the session is left room for the state topics.
void MqttWork::publish_answers(Instant now) {
    auto& desk = options_.commands->desk;
    while (const auto* const answer = desk.first_answer()) {
        const auto status = session_->status();
        if (status.state != MqttState::connected || status.live_waiting + 4 > options_.session.live_queue)
            return;
        // Of an answer that can never be sent, the session counts the loss.
        static_cast<void>(session_->publish(now, LiveMessage(*answer)));
        desk.remove_first_answer();
    }
}

void MqttWork::on_connected(Instant now, MqttConnectionId) {
    status_at_ = now;
    retained_wanted_ = std::exchange(connected_before_, true);
}

void MqttWork::on_disconnected(Instant, MqttConnectionId) {
    status_at_ = kNever;
}

void MqttWork::on_message(Instant now, MqttInbound&& inbound) {
    if (!options_.commands) return;
    auto& [desk, rights] = *options_.commands;
    if (const auto& current = options_.host->configuration(); current != rights_of_) {
        rights_of_ = current;
        desk.set_rights(rights(current));
    }
    const auto broker = url_of(options_.session.brokers[session_->status().broker]);
    desk.on_message(in_both_clocks(now), broker, inbound);
}

bool MqttWork::takes_records() const {
    return session_ && session_->status().state == MqttState::connected;
}

void MqttWork::stop(Instant now) {
    status_at_ = kNever;
    if (options_.commands) {
        execute_commands(now);
        options_.commands->desk.stop(in_both_clocks(now));
        publish_answers(now);
    }
    session_->stop(now);
}

bool MqttWork::stopped() const {
    return !session_ || session_->status().state == MqttState::off;
}

void MqttWork::report(Instant, OutputStatus& status) const {
    if (!session_) return;
    const auto mqtt = session_->status();
    status.state = state_of(mqtt);
    status.destination = url_of(options_.session.brokers[mqtt.broker]);
    if (mqtt.failure) status.failure = failure_text(*mqtt.failure);
    status.mqtt = mqtt;
    status.remedies = options_.remedies;
    status.too_large = messages_->too_large();
    if (!options_.commands) return;
    const auto counters = options_.commands->desk.counters();
    status.commands = counters.received;
    status.commands_refused = counters.refused;
    status.answers_dropped = counters.answers_dropped;
    status.commands_unrecorded = counters.unrecorded;
}

}  // namespace takt::publish
