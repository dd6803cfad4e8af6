// What a user sees of an MQTT session.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "takt/base/time.hpp"
#include "takt/publish/mqtt_port.hpp"

namespace takt::publish {

enum class MqttState : std::uint8_t {
    off,          ///< not started, or stopped by the owner
    connecting,   ///< resolving, connecting, CONNECT, SUBSCRIBE
    connected,    ///< messages are sent
    leaving,      ///< waits for acknowledgements, says farewell, disconnects
    backing_off,  ///< waits for the next attempt
    stopped,      ///< another client uses the client identifier; the next attempt is minutes away
};

/// Totals since the session was made.
struct MqttCounters {
    // Messages of the source.
    std::uint64_t published = 0;     ///< handed to the pipe, repeated ones included
    std::uint64_t repeated = 0;      ///< of them: marked so by the source
    std::uint64_t acknowledged = 0;  ///< by the broker
    std::uint64_t unproved = 0;      ///< QoS 0: handed to the operating system, no acknowledgement exists
    std::uint64_t no_subscribers =
        0;                       ///< of the acknowledged ones: the broker had no subscriber (MQTT 5 only)
    std::uint64_t rejected = 0;  ///< can never be sent; the source counts them as lost
    std::uint64_t refused = 0;   ///< the broker did not take them; they are sent again
    // Live messages.
    std::uint64_t live_published = 0;  ///< acknowledged or handed over
    std::uint64_t live_dropped = 0;  ///< queue full, expired, refused by the broker, or of a lost connection
    std::uint64_t received = 0;      ///< messages from the broker
    std::uint64_t oversized = 0;     ///< messages from the broker that were dropped for their size
    // Connections.
    std::uint64_t attempts = 0;
    std::uint64_t connects = 0;          ///< attempts that the broker accepted
    std::uint64_t lost_connections = 0;  ///< they ended without the session's will
};

struct MqttStatus {
    MqttState state = MqttState::off;
    Instant since{};                     ///< of the state
    Instant next_attempt = kNever;       ///< backing_off and stopped only
    std::size_t broker = 0;              ///< index: of the connection, else of the next or last attempt
    std::optional<MqttVersion> version;  ///< of the connection
    bool subscribed = false;             ///< the broker accepted all subscriptions of this connection
    bool qos_0_only = false;             ///< the broker takes QoS 0 only: delivery is not proved
    bool retain_unavailable = false;     ///< the broker keeps no retained messages
    std::optional<std::uint32_t> maximum_packet;  ///< bytes of a packet that the broker takes; none: no limit
    std::chrono::seconds keep_alive{0};           ///< of the connection, possibly the broker's
    std::size_t window = 0;                       ///< messages that may be in flight now
    std::optional<Duration> round_trip;           ///< from a message to its acknowledgement, smoothed
    std::size_t in_flight = 0;                    ///< messages that the broker has not acknowledged
    std::size_t live_waiting = 0;                 ///< live messages in the queue, those in flight included
    bool refusing = false;  ///< the broker refuses a message of the source; it is sent again after pauses
    /// That is not over, of the connection, else of a message, the subscriptions, or a live message.
    std::optional<MqttFailure> failure;
    std::optional<MqttFailure> last_failure;  ///< of a connection, subscription or message
    Instant last_failure_at{};
    MqttOversized last_oversized;  ///< if `oversized` is counted
    MqttCounters counters;
};

/// The stable name of a state, as in "backing_off".
std::string_view name(MqttState state);

}  // namespace takt::publish
