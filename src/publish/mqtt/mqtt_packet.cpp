#include "mqtt/mqtt_packet.hpp"

#include <algorithm>

#include "takt/base/utf8.hpp"

namespace takt::publish {
namespace {

constexpr std::size_t kLongestString = 65535;
constexpr std::size_t kLongestRemaining = 268'435'455;  // MQTT 5.0, 1.5.5 Variable Byte Integer

std::size_t varint_size(std::size_t value) {
    return value < 128 ? 1 : value < 16'384 ? 2 : value < 2'097'152 ? 3 : 4;
}

// A property: its identifier, and a string or binary with its length.
std::size_t text_size(std::string_view text) {
    return text.empty() ? 0 : 1 + 2 + text.size();
}

std::size_t properties_size(const MqttProperties& properties) {
    std::size_t size = text_size(properties.response_topic) + text_size(properties.correlation_data) +
                       text_size(properties.content_type) + (properties.expiry_s ? 1 + 4 : 0);
    for (const auto& user : properties.user) size += 1 + 2 + user.name.size() + 2 + user.value.size();
    return size;
}

std::size_t remaining_length(const MqttMessage& message, MqttVersion version) {
    std::size_t size = 2 + message.topic.size() + (message.qos > 0 ? 2 : 0) + message.payload.size();
    if (version == MqttVersion::v5) {
        const std::size_t properties = properties_size(message.properties);
        size += varint_size(properties) + properties;
    }
    return size;
}

// MQTT 5.0, 1.5.4: control characters and noncharacters should not be sent; brokers may close the connection.
bool is_permitted(char32_t code) {
    const bool control = code < 0x20 || (code >= 0x7F && code < 0xA0);
    const bool noncharacter = (code & 0xFFFE) == 0xFFFE || (code >= 0xFDD0 && code <= 0xFDEF);
    return !control && !noncharacter;
}

bool is_text(std::string_view text) {
    if (text.size() > kLongestString) return false;
    while (!text.empty()) {
        const auto [code, bytes] = first_character(text);
        if (bytes == 0 || !is_permitted(code)) return false;
        text.remove_prefix(bytes);
    }
    return true;
}

bool are_valid(const MqttProperties& properties) {
    return properties.correlation_data.size() <= kLongestString && is_text(properties.content_type) &&
           std::ranges::all_of(properties.user,
                               [](const auto& user) { return is_text(user.name) && is_text(user.value); });
}

}  // namespace

std::size_t publish_packet_size(const MqttMessage& message, MqttVersion version) {
    const std::size_t remaining = remaining_length(message, version);
    return 1 + varint_size(remaining) + remaining;
}

bool is_topic_name(std::string_view topic) {
    return !topic.empty() && is_text(topic) && topic.find_first_of("+#") == std::string_view::npos;
}

MqttReason reason_not_to_send(const MqttMessage& message, MqttVersion version, std::size_t packet_limit) {
    if (!is_topic_name(message.topic)) return MqttReason::topic_name_invalid;
    if (version == MqttVersion::v5) {
        const auto& response_topic = message.properties.response_topic;
        if (!response_topic.empty() && !is_topic_name(response_topic)) return MqttReason::topic_name_invalid;
        if (!are_valid(message.properties)) return MqttReason::payload_format_invalid;
    }
    if (remaining_length(message, version) > kLongestRemaining) return MqttReason::packet_too_large;
    if (publish_packet_size(message, version) > packet_limit) return MqttReason::packet_too_large;
    return MqttReason::success;
}

}  // namespace takt::publish
