// What a PUBLISH packet permits, and its size.
#pragma once

#include <cstddef>
#include <string_view>

#include "takt/publish/mqtt_port.hpp"

namespace takt::publish {

/// Bytes of the PUBLISH packet with its fixed header (MQTT 5.0, 3.3).
[[nodiscard]] std::size_t publish_packet_size(const MqttMessage& message, MqttVersion version);

/// UTF-8 of 1 to 65,535 bytes without control characters and wildcards.
[[nodiscard]] bool is_topic_name(std::string_view topic);

/// Why a message can never be sent to a broker with this limit; success: it can.
/// @param packet_limit  bytes of a packet
[[nodiscard]] MqttReason reason_not_to_send(const MqttMessage& message, MqttVersion version,
                                            std::size_t packet_limit);

}  // namespace takt::publish
