// The brokers, and the network between them and the gateway.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clock.hpp"
#include "complaints.hpp"
#include "scenario.hpp"
#include "takt/publish/mqtt_pipe.hpp"
#include "takt/sim/random.hpp"

namespace takt::gatewaysim {

/// Sees what passes between the gateway and the brokers.
class NetworkObserver {
public:
    /// The gateway gave it to its pipe.
    virtual void on_action(const publish::MqttAction& action) = 0;
    /// The gateway took it from its pipe.
    virtual void on_event(const publish::MqttEvent& event) = 0;
    /// The broker has the message, whether or not its PUBACK arrives.
    virtual void on_received(publish::MqttConnectionId connection, publish::MqttToken token,
                             const publish::MqttMessage& message) = 0;

protected:
    ~NetworkObserver() = default;
};

/// Packets of one direction arrive in their order, after a delay. A connection that ends loses what is on its
/// way. One gateway at a time.
class Network {
public:
    Network(const Scenario& scenario, const Clock& clock, NetworkObserver& observer, Complaints& complaints);

    /// The pipe of a run of the program.
    [[nodiscard]] std::unique_ptr<publish::MqttPipe> connect();
    /// When the gateway has an event to take; kNever: there is none.
    [[nodiscard]] Instant next_for_gateway() const;
    /// @param is_dead  the program does not exist any more: what it sends has no effect
    void set_death(std::function<bool()> is_dead) { is_dead_ = std::move(is_dead); }
    void on_process_ended();

    [[nodiscard]] Instant next_event() const;
    void advance();

    /// A client of all brokers publishes a command.
    void publish_command(const publish::MqttMessage& message);

    void set_away(std::size_t broker, bool away);
    void forget(std::size_t broker);
    void cut(const publish::MqttFailure& failure);
    void make_half_open();
    void take_over();
    /// From now on brokers and network do what they should.
    void end_troubles();

    [[nodiscard]] std::size_t brokers() const { return brokers_.size(); }
    /// The payload that a broker keeps of a topic; empty: none.
    [[nodiscard]] std::string retained(std::size_t broker, const std::string& topic) const;

private:
    friend class NetworkPipe;

    struct Packet {
        Instant arrives;
        publish::MqttAction action;
    };
    struct Connection {
        publish::MqttConnectionId id = 0;
        std::size_t broker = 0;
        publish::MqttVersion version = publish::MqttVersion::v5;
        std::optional<publish::MqttMessage> will;
        bool open = false;        // CONNACK was sent
        bool subscribed = false;  // the broker has the subscriptions
        bool half_open = false;
        Instant last_up{};
        Instant last_down{};
        Instant lost_at = kNever;  // the link breaks then
        std::deque<Packet> up;
    };
    struct Broker {
        BrokerTraits traits;
        bool away = false;
        std::map<std::string, publish::MqttMessage> retained;
        std::deque<publish::MqttMessage> stale;  // commands that had no subscriber
    };

    void send(publish::MqttAction&& action);
    [[nodiscard]] std::optional<publish::MqttEvent> take_event();
    void on(publish::MqttConnect&& connect);
    void on(publish::MqttPublish&& publish);
    void on(publish::MqttSubscribe&& subscribe);
    void on(publish::MqttDisconnect&& disconnect);
    [[nodiscard]] std::optional<publish::MqttFailure> refusal(const publish::MqttConnect& connect);
    void accept(const publish::MqttConnect& connect);
    void send_up(publish::MqttAction&& action);
    void send_down(publish::MqttEvent&& event, Duration more = {});
    void close(const publish::MqttFailure& failure, Duration after);
    void publish_will();
    void arrive(Packet&& packet);
    void process(const publish::MqttPublish& publish);
    void process(const publish::MqttSubscribe& subscribe);
    void store(const publish::MqttMessage& message);
    void answer(const publish::MqttPublish& publish);
    void hand_out(const publish::MqttMessage& message, bool retain);
    [[nodiscard]] Broker& broker() { return brokers_[connection_->broker]; }
    [[nodiscard]] Duration delay();
    [[nodiscard]] bool roll(std::uint32_t per_million) {
        return per_million > 0 && random_.chance(per_million);
    }

    const Clock& clock_;
    NetworkObserver& observer_;
    Complaints& complaints_;
    sim::Random random_;
    std::vector<Broker> brokers_;
    std::optional<Connection> connection_;
    std::multimap<Instant, publish::MqttEvent> inbox_;  // events for the gateway
    std::function<bool()> is_dead_ = [] { return false; };
};

}  // namespace takt::gatewaysim
