// The MQTT session of an output: a pure engine between a source of messages and a pipe.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/publish/message_source.hpp"
#include "takt/publish/mqtt_port.hpp"
#include "takt/publish/mqtt_status.hpp"

namespace takt::publish {

enum class MqttVersions : std::uint8_t {
    automatic,  ///< 5; 3.1.1 where a broker refuses 5
    only_5,
    only_3_1_1,
};

struct MqttSessionOptions {
    std::vector<MqttBroker> brokers;  ///< in order of preference; at least one
    MqttVersions versions = MqttVersions::automatic;
    std::string client_id;
    std::string user;      ///< empty: none
    std::string password;  ///< never logged
    std::chrono::seconds keep_alive{30};
    std::vector<MqttSubscription> subscriptions;
    /// The first message of each connection, after the subscriptions are accepted: state topic "online".
    std::optional<MqttMessage> birth;
    /// The will: state topic "offline". Also published before an orderly end of a connection.
    std::optional<MqttMessage> will;

    std::size_t window = 64;      ///< messages in flight, 1 to 256
    std::size_t live_queue = 64;  ///< live messages that wait or are in flight

    Duration connect_timeout = std::chrono::seconds(20);  ///< from MqttConnect to MqttConnected
    Duration answer_timeout = std::chrono::seconds(30);   ///< without the acknowledgement that is due first
    /// For acknowledgements and the last state message at stop().
    Duration leave_timeout = std::chrono::milliseconds(1500);
    /// After the first failure; doubles with each further one.
    Duration first_pause = std::chrono::seconds(1);
    Duration longest_pause = std::chrono::seconds(60);
    /// Instead of longest_pause, after refused, unreachable and timed-out attempts at nearby addresses only.
    Duration longest_nearby_pause = std::chrono::seconds(10);
    /// The least pause after a failure that a user must clear: password, certificate, quota.
    Duration refused_pause = std::chrono::seconds(30);
    Duration taken_over_pause = std::chrono::minutes(5);  ///< after session_taken_over
    /// A connection of this length makes the pause short again.
    Duration stable_after = std::chrono::seconds(10);
    /// From the connection to another broker to the attempt at the preferred one; doubles with each failed
    /// attempt up to eight times this.
    Duration return_after = std::chrono::minutes(10);
    std::uint64_t seed = 0;  ///< of the jitter: each pause is up to half shorter
};

/// A message that is not of the source: a state topic, the answer to a command.
struct LiveMessage {
    MqttMessage message;
    std::string short_payload;  ///< sent where the broker's packet limit excludes the whole; empty: none
    Instant expires = kNever;   ///< dropped if it is not acknowledged until then
    bool this_connection_only = false;  ///< dropped with the connection, not accepted without one
};

/// A message from the broker.
struct MqttInbound {
    MqttConnectionId connection = 0;
    /// The broker has accepted all subscriptions of this connection. A command that comes before may be one
    /// that waited for an earlier connection.
    bool subscribed = false;
    MqttMessage message;
};

/// What the owner of a session learns. Called within the session's functions; may call
/// MqttSession::publish(), nothing else of the session.
class MqttListener {
public:
    /// Messages are sent from now on. The owner publishes its state topics again.
    virtual void on_connected(Instant now, MqttConnectionId connection) = 0;
    /// Follows on_connected().
    virtual void on_disconnected(Instant now, MqttConnectionId connection) = 0;
    virtual void on_message(Instant now, MqttInbound&& inbound) = 0;

protected:
    ~MqttListener() = default;
};

/// Keeps one connection to one of several brokers, and moves the messages of a source to it, at least once
/// and in order.
///
///   - Connections have a clean start: what a broker has not acknowledged is sent again from the source.
///   - The source's cursor moves in order, by acknowledgements with a reason below 0x80 only. QoS 0: when the
///     message was handed to the operating system.
///   - A broker that refuses a message (0x80 and above) gets it again after a pause, the window begins with
///     one message. packet_too_large, topic_name_invalid and payload_format_invalid are final.
///   - Live messages go before those of the source.
///   - Two connections never exist at once, also while the session moves to another broker.
///
/// No clock, thread or socket: the owner calls on_event() with each event of the pipe, on_tick() at
/// next_wakeup(), and after each of these calls, after publish() and when the source has new messages,
/// next_action() until it returns nothing. Time must not run backwards. One owner, one thread.
class MqttSession {
public:
    /// @param source, listener  must outlive the session
    MqttSession(MqttSessionOptions options, MessageSource& source, MqttListener& listener);
    MqttSession(MqttSession&&) noexcept;
    MqttSession& operator=(MqttSession&&) noexcept;
    ~MqttSession();

    /// Connects. No effect unless the state is off.
    void start(Instant now);
    /// Waits for acknowledgements and publishes the will, for leave_timeout at most; then disconnects. The
    /// state is off at the end.
    void stop(Instant now);
    void on_event(Instant now, MqttEvent&& event);
    void on_tick(Instant now);
    [[nodiscard]] Instant next_wakeup() const;
    [[nodiscard]] std::optional<MqttAction> next_action(Instant now);

    /// Enqueues a live message. @returns false: dropped and counted, because the queue is full, the message
    /// can never be sent, or it is for this connection only and there is none
    bool publish(Instant now, LiveMessage&& live);

    [[nodiscard]] MqttStatus status() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace takt::publish
