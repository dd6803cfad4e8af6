// The port between the MQTT session engine and its transport: a library on a real network, or a simulated
// broker. Plain values; no socket, thread or clock.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "takt/publish/mqtt_reason.hpp"

namespace takt::publish {

enum class MqttVersion : std::uint8_t { v3_1_1 = 4, v5 = 5 };

/// Files in PEM. The certificate of the broker is always checked, against the broker's host name also.
struct MqttTls {
    std::string ca_file;           ///< empty: the authorities that the operating system trusts
    std::string certificate_file;  ///< of the client; empty: none
    std::string key_file;          ///< of the client's certificate
    std::string alpn;              ///< as in "x-amzn-mqtt-ca"; empty: none

    friend bool operator==(const MqttTls&, const MqttTls&) = default;
};

struct MqttBroker {
    std::string host;
    std::uint16_t port = 1883;
    std::optional<MqttTls> tls;  ///< TLS 1.2 or 1.3

    friend bool operator==(const MqttBroker&, const MqttBroker&) = default;
};

struct MqttUserProperty {
    std::string name;
    std::string value;

    friend bool operator==(const MqttUserProperty&, const MqttUserProperty&) = default;
};

/// Properties of a message in MQTT 5. A connection of 3.1.1 drops them.
struct MqttProperties {
    std::string response_topic;             ///< empty: none
    std::string correlation_data;           ///< any bytes; empty: none
    std::optional<std::uint32_t> expiry_s;  ///< Message Expiry Interval
    std::string content_type;               ///< empty: none
    std::vector<MqttUserProperty> user;

    [[nodiscard]] bool empty() const {
        return response_topic.empty() && correlation_data.empty() && !expiry_s && content_type.empty() &&
               user.empty();
    }
    friend bool operator==(const MqttProperties&, const MqttProperties&) = default;
};

struct MqttMessage {
    std::string topic;
    std::string payload;   ///< any bytes
    std::uint8_t qos = 1;  ///< 0 to 2
    bool retain = false;   ///< received: see MqttReceived
    MqttProperties properties;

    friend bool operator==(const MqttMessage&, const MqttMessage&) = default;
};

/// Number of a connection: given by MqttConnect, > 0, ascending. Every later action and event carries it. An
/// event of another connection than the current one is out of date.
using MqttConnectionId = std::uint64_t;

/// Number of a publish or subscribe action: > 0, never used twice by a session.
using MqttToken = std::uint64_t;

// Actions: from the session to the pipe.

/// Opens a connection with Clean Start (3.1.1: Clean Session) and a session that ends with it. There is at
/// most one connection at a time: the next MqttConnect follows the MqttClosed of the one before.
struct MqttConnect {
    MqttConnectionId connection = 0;
    MqttBroker broker;
    MqttVersion version = MqttVersion::v5;
    std::string client_id;
    std::string user;      ///< empty: none
    std::string password;  ///< never logged
    std::chrono::seconds keep_alive{30};
    std::optional<MqttMessage> will;
};

/// Answered by MqttAcknowledged with the same token, unless MqttClosed comes before.
struct MqttPublish {
    MqttConnectionId connection = 0;
    MqttToken token = 0;
    MqttMessage message;
};

struct MqttSubscription {
    std::string filter;
    std::uint8_t qos = 1;

    friend bool operator==(const MqttSubscription&, const MqttSubscription&) = default;
};

/// Answered by MqttSubscribed with the same token, unless MqttClosed comes before. In MQTT 5 with Retain As
/// Published, so that the retain flag of a received message is the sender's.
struct MqttSubscribe {
    MqttConnectionId connection = 0;
    MqttToken token = 0;
    std::vector<MqttSubscription> subscriptions;  ///< at least one
};

/// Ends the connection, also one that is still being opened. Answered by MqttClosed.
struct MqttDisconnect {
    MqttConnectionId connection = 0;
    /// false: closed without a DISCONNECT packet, so that the broker publishes the will.
    bool orderly = true;
};

using MqttAction = std::variant<MqttConnect, MqttPublish, MqttSubscribe, MqttDisconnect>;

// Events: from the pipe to the session, in the order in which they happened.

/// CONNACK with success. The limits are those of the broker; MQTT 3.1.1 has the defaults.
struct MqttConnected {
    MqttConnectionId connection = 0;
    std::uint16_t receive_maximum = 65535;        ///< messages of QoS > 0 in flight; > 0
    std::optional<std::uint32_t> maximum_packet;  ///< bytes of a packet
    std::uint8_t maximum_qos = 2;
    bool retain_available = true;
    std::optional<std::uint16_t> server_keep_alive;  ///< seconds; replaces that of MqttConnect
};

/// Why a connection failed or ended. Stable; the texts are elsewhere.
enum class MqttFailureKind : std::uint8_t {
    none,                ///< MqttDisconnect ended it
    dns,                 ///< the host name has no address, or no name server answered
    refused,             ///< no program listens on the port
    unreachable,         ///< no route, network or host down
    timed_out,           ///< no answer: to the connection, CONNECT, a ping or a message
    lost,                ///< reset or closed without a reason
    tls_unknown_issuer,  ///< the certificate's issuer is not trusted, or it is self-signed
    tls_expired,         ///< the certificate has expired or is not valid yet
    tls_other_name,      ///< the certificate is for another host name
    tls_files,           ///< a file of MqttTls cannot be read or does not fit the others
    tls,                 ///< any other failure of TLS; also a broker that demands a client certificate
    version,             ///< the broker does not speak this version of MQTT
    not_authorized,      ///< user, password, client identifier or certificate rejected, or banned
    session_taken_over,  ///< another client uses the same client identifier
    quota,               ///< quota, rate of messages or of connections exceeded
    unavailable,         ///< the broker is busy, shuts down, or names another server
    protocol,            ///< a packet violates the protocol or the broker's limits
    local,               ///< out of memory, or an argument that the library rejects
};

struct MqttFailure {
    MqttFailureKind kind = MqttFailureKind::none;
    MqttReason reason = MqttReason::success;  ///< of CONNACK or DISCONNECT; success: none was received
    std::string text;                         ///< of the library or broker; empty: none. Never a secret

    friend bool operator==(const MqttFailure&, const MqttFailure&) = default;
};

/// The connection does not exist any more, or was never opened: exactly one for each MqttConnect, its last
/// event.
struct MqttClosed {
    MqttConnectionId connection = 0;
    MqttFailure failure;
    bool nearby = false;  ///< all addresses of the broker are nearby (IpAddress::is_nearby)
};

/// QoS 1 and 2: PUBACK or PUBCOMP. QoS 0: the packet was handed to the operating system. A message that the
/// pipe cannot send is acknowledged with packet_too_large, topic_name_invalid or payload_format_invalid.
struct MqttAcknowledged {
    MqttConnectionId connection = 0;
    MqttToken token = 0;
    MqttReason reason = MqttReason::success;
};

/// SUBACK: a reason for each subscription. A granted QoS (0 to 2) is a success.
struct MqttSubscribed {
    MqttConnectionId connection = 0;
    MqttToken token = 0;
    std::vector<MqttReason> reasons;
};

/// PUBLISH from the broker. `retain` of the message: a retained message that the broker kept, or in MQTT 5
/// any message that its sender marked so.
struct MqttReceived {
    MqttConnectionId connection = 0;
    MqttMessage message;
};

/// The largest packet that a pipe takes from a broker. In MQTT 5 the Maximum Packet Size of CONNECT.
inline constexpr std::size_t kMostReceivedBytes = std::size_t{12} << 10U;

/// A PUBLISH from the broker above kMostReceivedBytes. It was dropped as it arrived, and is acknowledged.
struct MqttOversized {
    MqttConnectionId connection = 0;
    std::string topic;      ///< cut to 200 bytes
    std::size_t bytes = 0;  ///< of the packet
};

using MqttEvent =
    std::variant<MqttConnected, MqttClosed, MqttAcknowledged, MqttSubscribed, MqttReceived, MqttOversized>;

/// The stable name of a kind, as in "tls_expired".
std::string_view name(MqttFailureKind kind);

/// The kind for a reason code of CONNACK or DISCONNECT that is a failure.
MqttFailureKind failure_kind(MqttReason reason);

}  // namespace takt::publish
