// What the brokers do with the packets that arrive, and what happens to them.
#include <array>
#include <utility>

#include "network.hpp"
#include "project_text.hpp"

namespace takt::gatewaysim {

using namespace std::chrono_literals;
using namespace publish;  // NOLINT(*-using-namespace): the types of the port

namespace {

constexpr std::size_t kMostStale = 20;

bool is_command_topic(const std::string& topic) {
    const std::string control = kControlTopic;
    return topic == control + "/command" || topic.starts_with(control + "/set/");
}

}  // namespace

void Network::arrive(Packet&& packet) {
    std::visit(
        [this](const auto& its) {
            if constexpr (requires { process(its); }) process(its);
        },
        packet.action);
}

void Network::process(const MqttPublish& publish) {
    const auto& traits = broker().traits;
    if (roll(traits.cut)) {
        complaints_.count("cut_at_message");
        if (random_.below(2) == 0) {
            observer_.on_received(connection_->id, publish.token, publish.message);
            store(publish.message);
        }
        return close({MqttFailureKind::lost, {}, {}}, 0ms);
    }
    answer(publish);
}

// PUBACK of MQTT 3.1.1 has no reason: such a broker closes the connection instead.
void Network::answer(const MqttPublish& publish) {
    const auto& traits = broker().traits;
    const bool proved = publish.message.qos > 0;
    const bool refused = proved && roll(traits.refused);
    if (refused || (proved && roll(traits.impossible))) {
        complaints_.count(refused ? "message_refused" : "message_impossible");
        constexpr std::array kRefused{MqttReason::quota_exceeded, MqttReason::implementation_specific,
                                      MqttReason::not_authorized, MqttReason::unspecified};
        constexpr std::array kImpossible{MqttReason::packet_too_large, MqttReason::topic_name_invalid,
                                         MqttReason::payload_format_invalid};
        if (connection_->version == MqttVersion::v3_1_1) return close({MqttFailureKind::lost, {}, {}}, 0ms);
        const auto reason = refused ? kRefused[random_.below(kRefused.size())]
                                    : kImpossible[random_.below(kImpossible.size())];
        return send_down(MqttAcknowledged{connection_->id, publish.token, reason});
    }
    observer_.on_received(connection_->id, publish.token, publish.message);
    store(publish.message);
    if (!proved) return;
    if (roll(traits.lost_puback)) return complaints_.count("puback_lost");
    const bool v5 = connection_->version == MqttVersion::v5;
    const auto reason =
        v5 && random_.below(4) == 0 ? MqttReason::no_matching_subscribers : MqttReason::success;
    const MqttAcknowledged acknowledged{connection_->id, publish.token, reason};
    if (roll(traits.late_puback) && !connection_->half_open) {
        complaints_.count("puback_late");
        inbox_.emplace(connection_->last_down + random_.between(1ms, 500ms), acknowledged);
        return;
    }
    send_down(MqttEvent(acknowledged));
    if (!roll(traits.repeated_puback)) return;
    complaints_.count("puback_repeated");
    send_down(MqttEvent(acknowledged));
}

void Network::store(const MqttMessage& message) {
    auto& all = broker().retained;
    if (!message.retain) return;
    if (message.payload.empty())
        all.erase(message.topic);
    else
        all[message.topic] = message;
}

void Network::process(const MqttSubscribe& subscribe) {
    auto& its = broker();
    const bool fails = roll(its.traits.suback_fails);
    auto stale = std::exchange(its.stale, {});
    if (roll(its.traits.stale_early)) {
        for (const auto& message : stale) hand_out(message, false);
        complaints_.count("command_before_suback", stale.size());
        stale.clear();
    }
    std::vector<MqttReason> reasons(subscribe.subscriptions.size(), MqttReason::success);
    if (fails) reasons.back() = MqttReason::not_authorized;
    if (fails) complaints_.count("suback_failed");
    const bool early = random_.below(4) == 0;
    const auto suback = [&] { send_down(MqttSubscribed{connection_->id, subscribe.token, reasons}); };
    if (!early) suback();
    for (const auto& [topic, message] : its.retained)
        if (is_command_topic(topic)) hand_out(message, true);
    if (early) suback();
    for (const auto& message : stale) hand_out(message, false);
    complaints_.count("command_after_outage", stale.size());
    connection_->subscribed = true;
}

void Network::hand_out(const MqttMessage& message, bool retain) {
    MqttReceived received{connection_->id, message};
    received.message.retain = retain;
    if (connection_->version == MqttVersion::v3_1_1) received.message.properties = {};
    send_down(std::move(received));
}

// With Retain As Published a live message has the flag of its sender; with 3.1.1 it has none.
void Network::publish_command(const MqttMessage& message) {
    for (std::size_t i = 0; i < brokers_.size(); ++i) {
        auto& its = brokers_[i];
        if (its.away) continue;
        if (message.retain) its.retained[message.topic] = message;
        if (!connection_ || connection_->broker != i || !connection_->subscribed) {
            if (!message.retain && its.stale.size() < kMostStale) its.stale.push_back(message);
            continue;
        }
        const bool flag = message.retain && connection_->version == MqttVersion::v5;
        hand_out(message, flag);
        if (!roll(its.traits.repeated_command)) continue;
        complaints_.count("command_repeated");
        hand_out(message, flag);
    }
}

void Network::set_away(std::size_t broker, bool away) {
    brokers_[broker].away = away;
    if (!away || !connection_ || connection_->broker != broker) return;
    const bool says_why = connection_->version == MqttVersion::v5 && random_.below(2) == 0;
    const auto reason = MqttReason::server_shutting_down;
    cut(says_why ? MqttFailure{failure_kind(reason), reason, {}}
                 : MqttFailure{MqttFailureKind::lost, {}, {}});
}

void Network::forget(std::size_t broker) {
    brokers_[broker].retained.clear();
    brokers_[broker].stale.clear();
    if (connection_ && connection_->broker == broker) cut({MqttFailureKind::lost, {}, {}});
}

void Network::cut(const MqttFailure& failure) {
    if (!connection_) return;
    complaints_.count("cut");
    close(failure, random_.between(0ms, 5ms));
}

// The pipe notices it after at most twice the keep-alive time.
void Network::make_half_open() {
    if (!connection_ || connection_->half_open) return;
    complaints_.count("half_open");
    connection_->half_open = true;
    connection_->up.clear();
    inbox_.erase(inbox_.upper_bound(clock_.now), inbox_.end());
    connection_->lost_at = clock_.now + random_.between(5s, 10s);
}

void Network::take_over() {
    if (!connection_ || !connection_->open) return;
    complaints_.count("taken_over");
    const auto reason = MqttReason::session_taken_over;
    const bool v5 = connection_->version == MqttVersion::v5;
    cut(v5 ? MqttFailure{failure_kind(reason), reason, {}} : MqttFailure{MqttFailureKind::lost, {}, {}});
}

void Network::end_troubles() {
    for (auto& its : brokers_) {
        its.away = false;
        auto& traits = its.traits;
        traits.lost_puback = traits.repeated_puback = traits.late_puback = traits.refused =
            traits.impossible = traits.cut = traits.not_accepted = traits.no_answer = traits.cut_early =
                traits.suback_fails = 0;
        traits.least_delay = std::min(traits.least_delay, Duration(300us));
        traits.most_delay = traits.least_delay + Duration(300us);
    }
}

}  // namespace takt::gatewaysim
