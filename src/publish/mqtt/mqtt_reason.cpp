#include "takt/publish/mqtt_reason.hpp"

namespace takt::publish {

std::string_view name(MqttReason reason) {
    switch (reason) {
        case MqttReason::success: return "success";
        case MqttReason::disconnect_with_will: return "disconnect_with_will";
        case MqttReason::no_matching_subscribers: return "no_matching_subscribers";
        case MqttReason::unspecified: return "unspecified";
        case MqttReason::malformed_packet: return "malformed_packet";
        case MqttReason::protocol_error: return "protocol_error";
        case MqttReason::implementation_specific: return "implementation_specific";
        case MqttReason::unsupported_protocol_version: return "unsupported_protocol_version";
        case MqttReason::client_identifier_not_valid: return "client_identifier_not_valid";
        case MqttReason::bad_user_name_or_password: return "bad_user_name_or_password";
        case MqttReason::not_authorized: return "not_authorized";
        case MqttReason::server_unavailable: return "server_unavailable";
        case MqttReason::server_busy: return "server_busy";
        case MqttReason::banned: return "banned";
        case MqttReason::server_shutting_down: return "server_shutting_down";
        case MqttReason::bad_authentication_method: return "bad_authentication_method";
        case MqttReason::keep_alive_timeout: return "keep_alive_timeout";
        case MqttReason::session_taken_over: return "session_taken_over";
        case MqttReason::topic_filter_invalid: return "topic_filter_invalid";
        case MqttReason::topic_name_invalid: return "topic_name_invalid";
        case MqttReason::packet_identifier_in_use: return "packet_identifier_in_use";
        case MqttReason::receive_maximum_exceeded: return "receive_maximum_exceeded";
        case MqttReason::packet_too_large: return "packet_too_large";
        case MqttReason::message_rate_too_high: return "message_rate_too_high";
        case MqttReason::quota_exceeded: return "quota_exceeded";
        case MqttReason::administrative_action: return "administrative_action";
        case MqttReason::payload_format_invalid: return "payload_format_invalid";
        case MqttReason::retain_not_supported: return "retain_not_supported";
        case MqttReason::qos_not_supported: return "qos_not_supported";
        case MqttReason::use_another_server: return "use_another_server";
        case MqttReason::server_moved: return "server_moved";
        case MqttReason::connection_rate_exceeded: return "connection_rate_exceeded";
    }
    return "unknown";
}

MqttReason from_connack_3_1_1(std::uint8_t return_code) {
    switch (return_code) {
        case 0: return MqttReason::success;
        case 1: return MqttReason::unsupported_protocol_version;
        case 2: return MqttReason::client_identifier_not_valid;
        case 3: return MqttReason::server_unavailable;
        case 4: return MqttReason::bad_user_name_or_password;
        case 5: return MqttReason::not_authorized;
        default: return MqttReason::unspecified;
    }
}

}  // namespace takt::publish
