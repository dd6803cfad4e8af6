// Where a session gets the messages that must not be lost.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "takt/base/time.hpp"
#include "takt/publish/mqtt_port.hpp"

namespace takt::publish {

inline constexpr std::size_t kNoPacketLimit = std::numeric_limits<std::size_t>::max();

/// What the current connection permits.
struct MessageLimits {
    MqttVersion version = MqttVersion::v5;
    std::size_t packet = kNoPacketLimit;  ///< bytes of a PUBLISH packet, see publish_packet_size()
};

struct SourceMessage {
    std::uint64_t token =
        0;                  ///< of the source, ascending; the same message has the same token after a rewind
    bool repeated = false;  ///< was returned before
    MqttMessage message;
};

/// An ordered stream of messages with a cursor, such as a journal. Called by one session only.
///
/// The cursor moves in the order of next(): acknowledge() and reject() are called once for each message, in
/// order, although acknowledgements arrive in any order.
class MessageSource {
public:
    /// The next message; none: nothing waits. Called again by each MqttSession::next_action().
    [[nodiscard]] virtual std::optional<SourceMessage> next(Instant now, const MessageLimits& limits) = 0;
    /// The broker has the message. QoS 0: it was handed to the operating system.
    virtual void acknowledge(Instant now, std::uint64_t token) = 0;
    /// The message can never be sent: packet_too_large, topic_name_invalid or payload_format_invalid. The
    /// source counts it as lost.
    virtual void reject(Instant now, std::uint64_t token, MqttReason reason) = 0;
    /// The following next() returns the message after the last one that was acknowledged or rejected.
    virtual void rewind() = 0;

protected:
    ~MessageSource() = default;
};

}  // namespace takt::publish
