#include "takt/publish/mqtt_port.hpp"

namespace takt::publish {

std::string_view name(MqttFailureKind kind) {
    switch (kind) {
        case MqttFailureKind::none: return "none";
        case MqttFailureKind::dns: return "dns";
        case MqttFailureKind::refused: return "refused";
        case MqttFailureKind::unreachable: return "unreachable";
        case MqttFailureKind::timed_out: return "timed_out";
        case MqttFailureKind::lost: return "lost";
        case MqttFailureKind::tls_unknown_issuer: return "tls_unknown_issuer";
        case MqttFailureKind::tls_expired: return "tls_expired";
        case MqttFailureKind::tls_other_name: return "tls_other_name";
        case MqttFailureKind::tls_files: return "tls_files";
        case MqttFailureKind::tls: return "tls";
        case MqttFailureKind::version: return "version";
        case MqttFailureKind::not_authorized: return "not_authorized";
        case MqttFailureKind::session_taken_over: return "session_taken_over";
        case MqttFailureKind::quota: return "quota";
        case MqttFailureKind::unavailable: return "unavailable";
        case MqttFailureKind::protocol: return "protocol";
        case MqttFailureKind::local: return "local";
    }
    return "unknown";
}

MqttFailureKind failure_kind(MqttReason reason) {
    switch (reason) {
        case MqttReason::unsupported_protocol_version: return MqttFailureKind::version;
        case MqttReason::client_identifier_not_valid:
        case MqttReason::bad_user_name_or_password:
        case MqttReason::not_authorized:
        case MqttReason::banned:
        case MqttReason::bad_authentication_method: return MqttFailureKind::not_authorized;
        case MqttReason::session_taken_over: return MqttFailureKind::session_taken_over;
        case MqttReason::message_rate_too_high:
        case MqttReason::quota_exceeded:
        case MqttReason::connection_rate_exceeded: return MqttFailureKind::quota;
        case MqttReason::server_unavailable:
        case MqttReason::server_busy:
        case MqttReason::server_shutting_down:
        case MqttReason::use_another_server:
        case MqttReason::server_moved: return MqttFailureKind::unavailable;
        case MqttReason::keep_alive_timeout: return MqttFailureKind::timed_out;
        case MqttReason::unspecified:
        case MqttReason::administrative_action: return MqttFailureKind::lost;
        default: return MqttFailureKind::protocol;
    }
}

}  // namespace takt::publish
