// The packets between a broker and the MQTT library: those that are too large stay outside.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "takt/publish/mqtt_port.hpp"

namespace takt::publish {

/// Finds the borders of packets in a stream of bytes (MQTT 5.0, 2.1: type, length, body).
class PacketCursor {
public:
    /// Takes bytes up to the end of the header or of the packet.
    /// @returns how many; 0: the length is malformed, or `bytes` is empty
    std::size_t take(std::string_view bytes);

    /// No byte of the next packet was taken.
    [[nodiscard]] bool is_between_packets() const { return header_bytes_ == 0; }
    /// The length of the packet is known, and its end was not taken.
    [[nodiscard]] bool is_in_body() const { return in_body_; }
    [[nodiscard]] bool is_malformed() const { return malformed_; }

    // Of the packet whose header was taken last.
    [[nodiscard]] std::uint8_t type() const { return first_byte_ >> 4U; }
    [[nodiscard]] std::uint8_t qos() const { return (first_byte_ >> 1U) & 3U; }
    [[nodiscard]] std::size_t body_bytes() const { return length_; }
    [[nodiscard]] std::size_t packet_bytes() const { return packet_bytes_; }

private:
    std::size_t take_header(std::string_view bytes);

    std::uint8_t first_byte_ = 0;
    std::size_t header_bytes_ = 0;
    std::size_t length_ = 0;
    std::size_t packet_bytes_ = 0;
    std::size_t left_ = 0;  // of the body
    bool in_body_ = false;
    bool malformed_ = false;
};

/// Passes packets of a broker to the library. A PUBLISH above the limit is dropped as its bytes arrive, so
/// that it needs no memory, and is acknowledged at its end: the broker does not send it again. Any other
/// packet above the limit ends the connection.
///
/// No socket. One owner, one thread.
class PacketGate {
public:
    static constexpr std::size_t kLongestTopic = 200;  ///< bytes of a topic that are kept
    /// Acknowledgements that may wait for the end of a packet to the broker. The owner reads no more then.
    static constexpr std::size_t kMostAcknowledgements = 64;

    struct Dropped {
        std::string topic;  ///< its first kLongestTopic bytes, then "…"; "?": it is no topic
        std::size_t bytes = 0;
    };

    /// @param limit  bytes of a packet
    explicit PacketGate(std::size_t limit) : limit_(limit) {}

    /// Appends to `out` what the library gets: at most five bytes more than came in.
    void from_broker(std::string_view bytes, std::string& out);
    /// Appends to `out` what the broker gets: these bytes, and acknowledgements between two packets.
    void to_broker(std::string_view bytes, std::string& out);

    /// The next PUBLISH that was dropped.
    [[nodiscard]] std::optional<Dropped> next_dropped();
    [[nodiscard]] bool may_read() const { return acknowledgements_.size() < kMostAcknowledgements; }
    /// Why the connection must end.
    [[nodiscard]] const std::optional<MqttFailure>& failure() const { return failure_; }

private:
    enum class Fate : std::uint8_t { unknown, pass, drop };

    void decide();
    void drop(std::string_view body);
    [[nodiscard]] std::size_t prefix_bytes() const;
    void end_dropped();
    void acknowledge(std::string& out);
    void fail(std::string text);

    std::size_t limit_;
    PacketCursor in_;
    PacketCursor out_;
    std::string header_;  // while the fate of its packet is unknown
    Fate fate_ = Fate::unknown;
    std::optional<MqttFailure> failure_;
    std::deque<Dropped> dropped_;
    std::deque<std::string> acknowledgements_;

    // Of the packet that is dropped.
    std::size_t offset_ = 0;  // in its body
    std::size_t topic_bytes_ = 0;
    std::string topic_;
    std::uint16_t identifier_ = 0;
};

}  // namespace takt::publish
