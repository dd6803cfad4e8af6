// Reason codes of MQTT 5, and the return codes of 3.1.1 that they replace.
#pragma once

#include <cstdint>
#include <string_view>

namespace takt::publish {

/// MQTT 5.0, 2.4 Reason Code. Codes of 3.1.1 are converted to these.
enum class MqttReason : std::uint8_t {
    success = 0x00,
    disconnect_with_will = 0x04,
    no_matching_subscribers = 0x10,
    unspecified = 0x80,
    malformed_packet = 0x81,
    protocol_error = 0x82,
    implementation_specific = 0x83,
    unsupported_protocol_version = 0x84,
    client_identifier_not_valid = 0x85,
    bad_user_name_or_password = 0x86,
    not_authorized = 0x87,
    server_unavailable = 0x88,
    server_busy = 0x89,
    banned = 0x8A,
    server_shutting_down = 0x8B,
    bad_authentication_method = 0x8C,
    keep_alive_timeout = 0x8D,
    session_taken_over = 0x8E,
    topic_filter_invalid = 0x8F,
    topic_name_invalid = 0x90,
    packet_identifier_in_use = 0x91,
    receive_maximum_exceeded = 0x93,
    packet_too_large = 0x95,
    message_rate_too_high = 0x96,
    quota_exceeded = 0x97,
    administrative_action = 0x98,
    payload_format_invalid = 0x99,
    retain_not_supported = 0x9A,
    qos_not_supported = 0x9B,
    use_another_server = 0x9C,
    server_moved = 0x9D,
    connection_rate_exceeded = 0x9F,
};

/// Whether the code reports a failure.
constexpr bool is_failure(MqttReason reason) {
    return static_cast<std::uint8_t>(reason) >= 0x80;
}

/// The stable name of a code as in "not_authorized"; "unknown" for a code that is not in the list.
std::string_view name(MqttReason reason);

/// The code of MQTT 5 for a return code of CONNACK in 3.1.1 (0 to 5); unspecified for others.
MqttReason from_connack_3_1_1(std::uint8_t return_code);

}  // namespace takt::publish
