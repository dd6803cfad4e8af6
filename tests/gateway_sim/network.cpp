#include "network.hpp"

#include <algorithm>
#include <utility>

#include "project_text.hpp"

namespace takt::gatewaysim {

using namespace std::chrono_literals;
using namespace publish;  // NOLINT(*-using-namespace): the types of the port

class NetworkPipe final : public MqttPipe {
public:
    explicit NetworkPipe(Network& network) : network_(network) {}

    void send(MqttAction&& action) override { network_.send(std::move(action)); }
    std::optional<MqttEvent> next_event() override { return network_.take_event(); }
    int descriptor() const override { return -1; }

private:
    Network& network_;
};

Network::Network(const Scenario& scenario, const Clock& clock, NetworkObserver& observer,
                 Complaints& complaints)
    : clock_(clock),
      observer_(observer),
      complaints_(complaints),
      random_(sim::Random(scenario.seed).fork(0x4E7)) {
    for (const auto& traits : scenario.brokers) brokers_.push_back({.traits = traits});
}

std::unique_ptr<MqttPipe> Network::connect() {
    return std::make_unique<NetworkPipe>(*this);
}

Duration Network::delay() {
    const auto& traits = broker().traits;
    return random_.between(traits.least_delay, traits.most_delay);
}

Instant Network::next_for_gateway() const {
    return inbox_.empty() ? kNever : inbox_.begin()->first;
}

std::optional<MqttEvent> Network::take_event() {
    if (is_dead_() || inbox_.empty() || inbox_.begin()->first > clock_.now) return std::nullopt;
    auto event = std::move(inbox_.begin()->second);
    inbox_.erase(inbox_.begin());
    observer_.on_event(event);
    return event;
}

void Network::send(MqttAction&& action) {
    if (is_dead_()) return;
    observer_.on_action(action);
    std::visit([this](auto&& its) { on(std::forward<decltype(its)>(its)); }, std::move(action));
}

// Opening a connection.
void Network::on(MqttConnect&& connect) {
    if (connection_) return;  // the judge reports it
    const std::size_t index = connect.broker.host == "two" ? 1 : 0;
    connection_ = Connection{.id = connect.connection, .broker = index, .version = connect.version};
    auto& traits = broker().traits;
    complaints_.count("connect");
    if (roll(broker().away ? 250'000 : traits.no_answer)) return complaints_.count("connect_unanswered");
    if (const auto failure = refusal(connect)) {
        complaints_.count("connect_refused");
        return close(*failure, delay());
    }
    accept(connect);
}

std::optional<MqttFailure> Network::refusal(const MqttConnect& connect) {
    const auto& [traits, away, retained, stale] = broker();
    constexpr std::array kAway{MqttFailureKind::refused, MqttFailureKind::unreachable, MqttFailureKind::dns};
    if (away) return MqttFailure{kAway[random_.below(kAway.size())], {}, {}};
    const auto with = [](MqttReason reason) { return MqttFailure{failure_kind(reason), reason, {}}; };
    const bool v5 = connect.version == MqttVersion::v5;
    if (v5 && !traits.speaks_5)
        return traits.closes_on_5 ? MqttFailure{MqttFailureKind::lost, {}, {}}
                                  : with(MqttReason::unsupported_protocol_version);
    if (!v5 && !traits.speaks_3_1_1) return with(MqttReason::unsupported_protocol_version);
    if (v5 && connect.will && connect.will->retain && !traits.limits.retain_available)
        return with(MqttReason::retain_not_supported);
    if (v5 && connect.will && connect.will->qos > traits.limits.maximum_qos)
        return with(MqttReason::qos_not_supported);
    constexpr std::array kReasons{MqttReason::server_unavailable, MqttReason::not_authorized,
                                  MqttReason::server_busy, MqttReason::quota_exceeded,
                                  MqttReason::bad_user_name_or_password};
    if (roll(traits.not_accepted)) return with(kReasons[random_.below(kReasons.size())]);
    return std::nullopt;
}

void Network::accept(const MqttConnect& connect) {
    const auto& traits = broker().traits;
    connection_->open = true;
    connection_->will = connect.will;
    connection_->last_up = connection_->last_down = clock_.now;
    MqttConnected connected{.connection = connect.connection};
    if (connect.version == MqttVersion::v5) {
        connected = traits.limits;
        connected.connection = connect.connection;
    }
    complaints_.count(connect.version == MqttVersion::v5 ? "connected_5" : "connected_3_1_1");
    send_down(connected, delay());
    if (!roll(traits.cut_early)) return;
    connection_->lost_at = connection_->last_down + random_.between(0ms, 3 * traits.most_delay);
    complaints_.count("cut_early");
}

// From the gateway to the broker.
void Network::on(MqttPublish&& publish) {
    if (!connection_ || publish.connection != connection_->id || !connection_->open) return;
    // The packet is handed to the operating system: that is all that QoS 0 proves.
    if (publish.message.qos == 0)
        inbox_.emplace(clock_.now + 50us, MqttAcknowledged{publish.connection, publish.token, {}});
    send_up(std::move(publish));
}

void Network::on(MqttSubscribe&& subscribe) {
    if (!connection_ || subscribe.connection != connection_->id || !connection_->open) return;
    send_up(std::move(subscribe));
}

void Network::send_up(MqttAction&& action) {
    auto& connection = *connection_;
    if (connection.half_open) return;
    connection.last_up = std::max(connection.last_up, clock_.now + delay());
    connection.up.push_back({connection.last_up, std::move(action)});
}

// What the broker has not received by then is lost, although a real DISCONNECT follows it: the session has
// waited for all acknowledgements.
void Network::on(MqttDisconnect&& disconnect) {
    if (!connection_ || disconnect.connection != connection_->id) return;
    if (disconnect.orderly) connection_->will.reset();
    close({}, random_.between(0ms, 20ms));
}

void Network::send_down(MqttEvent&& event, Duration more) {
    auto& connection = *connection_;
    if (connection.half_open) return;
    connection.last_down = std::max(connection.last_down, clock_.now + delay() + more);
    inbox_.emplace(connection.last_down, std::move(event));
}

/// The connection ends now, for the gateway after a while. Events until then are taken or lost.
void Network::close(const MqttFailure& failure, Duration after_now) {
    publish_will();
    const Instant end = after(clock_.now, after_now);
    inbox_.erase(inbox_.upper_bound(end), inbox_.end());
    inbox_.emplace(end, MqttClosed{connection_->id, failure});
    connection_.reset();
}

void Network::publish_will() {
    if (!connection_->open || !connection_->will) return;
    store(*std::exchange(connection_->will, std::nullopt));
}

void Network::on_process_ended() {
    inbox_.clear();
    if (!connection_) return;
    // The operating system may still send what the program gave it.
    auto up = std::move(connection_->up);
    const auto sent = random_.below(static_cast<std::uint32_t>(up.size()) + 1);
    for (std::size_t i = 0; i < sent && connection_; ++i) arrive(std::move(up[i]));
    inbox_.clear();
    if (connection_) publish_will();
    connection_.reset();
}

Instant Network::next_event() const {
    if (!connection_) return kNever;
    const Instant packet = connection_->up.empty() ? kNever : connection_->up.front().arrives;
    return std::min(packet, connection_->lost_at);
}

void Network::advance() {
    while (connection_ && next_event() <= clock_.now) {
        if (connection_->lost_at <= clock_.now) {
            close({connection_->half_open ? MqttFailureKind::timed_out : MqttFailureKind::lost, {}, {}}, {});
            return;
        }
        auto packet = std::move(connection_->up.front());
        connection_->up.pop_front();
        arrive(std::move(packet));
    }
}

std::string Network::retained(std::size_t broker, const std::string& topic) const {
    const auto& all = brokers_[broker].retained;
    const auto found = all.find(topic);
    return found == all.end() ? std::string() : found->second.payload;
}

}  // namespace takt::gatewaysim
