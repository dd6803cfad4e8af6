#include "mqtt/packet_gate.hpp"

#include <mqtt_protocol.h>

#include <algorithm>
#include <utility>

#include "mqtt/mqtt_packet.hpp"
#include "takt/base/utf8.hpp"

namespace takt::publish {
namespace {

constexpr std::size_t kMostLengthBytes = 4;  // MQTT 5.0, 1.5.5 Variable Byte Integer
constexpr std::uint8_t kPublish = CMD_PUBLISH >> 4U;

std::uint8_t byte_of(char c) {
    return static_cast<std::uint8_t>(c);
}

// The topic is for people: a broker may send anything.
std::string shown(std::string_view topic) {
    const auto front = whole_characters(topic, PacketGate::kLongestTopic);
    if (!is_topic_name(front)) return "?";
    return std::string(front) + (front.size() < topic.size() ? "…" : "");
}

}  // namespace

std::size_t PacketCursor::take(std::string_view bytes) {
    if (malformed_) return 0;
    if (!in_body_) return take_header(bytes);
    const std::size_t taken = std::min(bytes.size(), left_);
    left_ -= taken;
    if (left_ > 0) return taken;
    in_body_ = false;
    header_bytes_ = 0;
    return taken;
}

std::size_t PacketCursor::take_header(std::string_view bytes) {
    std::size_t taken = 0;
    while (taken < bytes.size()) {
        const std::uint8_t byte = byte_of(bytes[taken++]);
        if (header_bytes_++ == 0) {
            first_byte_ = byte;
            length_ = 0;
            continue;
        }
        length_ |= static_cast<std::size_t>(byte & 0x7FU) << (7U * (header_bytes_ - 2));
        if ((byte & 0x80U) == 0) {
            packet_bytes_ = header_bytes_ + length_;
            left_ = length_;
            in_body_ = true;
            return taken;
        }
        malformed_ = header_bytes_ > kMostLengthBytes;
        if (malformed_) return 0;
    }
    return taken;
}

void PacketGate::from_broker(std::string_view bytes, std::string& out) {
    while (!failure_) {
        // An empty body ends without a byte.
        if (bytes.empty() && !(in_.is_in_body() && in_.body_bytes() == 0)) return;
        const bool body = in_.is_in_body();
        const auto part = bytes.substr(0, in_.take(bytes));
        bytes.remove_prefix(part.size());
        if (in_.is_malformed()) return fail("a packet whose length has more than four bytes");
        if (!body) {
            header_ += part;
            if (in_.is_in_body()) decide();
            if (fate_ == Fate::pass) out += std::exchange(header_, {});
        } else if (fate_ == Fate::pass) {
            out += part;
        } else {
            drop(part);
        }
        if (!in_.is_between_packets()) continue;
        if (fate_ == Fate::drop) end_dropped();
        fate_ = Fate::unknown;
    }
}

// QoS 2 needs the memory of the library until PUBREL; subscriptions have QoS 1 at most.
void PacketGate::decide() {
    const bool publish = in_.type() == kPublish;
    if (publish && in_.qos() > 1 && in_.packet_bytes() <= limit_)
        return fail("PUBLISH with QoS " + std::to_string(in_.qos()) + "; subscribed was QoS 1");
    if (in_.packet_bytes() <= limit_) {
        fate_ = Fate::pass;
        return;
    }
    if (!publish || in_.qos() > 2)
        return fail("a packet of type " + std::to_string(in_.type()) + " with " +
                    std::to_string(in_.packet_bytes()) + " bytes; allowed: " + std::to_string(limit_));
    fate_ = Fate::drop;
    header_.clear();
    offset_ = topic_bytes_ = identifier_ = 0;
    topic_.clear();
}

// The body: the length of the topic in two bytes, the topic, the identifier if QoS > 0. The message is
// reported as soon as these are known: a slow broker may never send its end.
void PacketGate::drop(std::string_view body) {
    for (const char c : body) {
        if (offset_ >= 2 && offset_ == prefix_bytes()) return;
        if (offset_ < 2)
            topic_bytes_ = topic_bytes_ << 8U | byte_of(c);
        else if (offset_ >= 2 + topic_bytes_)
            identifier_ = static_cast<std::uint16_t>(identifier_ << 8U | byte_of(c));
        else if (topic_.size() <= kLongestTopic)
            topic_ += c;
        ++offset_;
        if (offset_ >= 2 && offset_ == prefix_bytes())
            dropped_.push_back({shown(std::exchange(topic_, {})), in_.packet_bytes()});
    }
}

std::size_t PacketGate::prefix_bytes() const {
    return 2 + topic_bytes_ + (in_.qos() > 0 ? 2 : 0);
}

void PacketGate::end_dropped() {
    if (offset_ < prefix_bytes() || (in_.qos() > 0 && identifier_ == 0))
        return fail("PUBLISH without a topic or an identifier");
    if (in_.qos() == 0) return;
    const int type = in_.qos() == 1 ? CMD_PUBACK : CMD_PUBREC;
    acknowledgements_.push_back({static_cast<char>(type), 2, static_cast<char>(identifier_ >> 8U),
                                 static_cast<char>(identifier_ & 0xFFU)});
}

void PacketGate::to_broker(std::string_view bytes, std::string& out) {
    if (out_.is_between_packets()) acknowledge(out);
    while (!bytes.empty()) {
        const auto part = bytes.substr(0, out_.take(bytes));
        if (part.empty()) return fail("the library sent a malformed packet");
        out += part;
        bytes.remove_prefix(part.size());
        if (out_.is_in_body() && out_.body_bytes() == 0) (void)out_.take({});
        if (out_.is_between_packets()) acknowledge(out);
    }
}

void PacketGate::acknowledge(std::string& out) {
    for (const auto& packet : std::exchange(acknowledgements_, {})) out += packet;
}

std::optional<PacketGate::Dropped> PacketGate::next_dropped() {
    if (dropped_.empty()) return {};
    auto dropped = std::move(dropped_.front());
    dropped_.pop_front();
    return dropped;
}

void PacketGate::fail(std::string text) {
    failure_ = MqttFailure{MqttFailureKind::protocol, {}, std::move(text)};
}

}  // namespace takt::publish
