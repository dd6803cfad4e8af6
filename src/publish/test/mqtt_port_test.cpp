#include "takt/publish/mqtt_port.hpp"

#include <gtest/gtest.h>

namespace takt::publish {
namespace mqtt_port_test {

TEST(MqttPort, AFailureHasTheKindOfItsReason) {
    const struct {
        MqttReason reason;
        MqttFailureKind kind;
    } rows[] = {
        {MqttReason::unsupported_protocol_version, MqttFailureKind::version},
        {MqttReason::bad_user_name_or_password, MqttFailureKind::not_authorized},
        {MqttReason::session_taken_over, MqttFailureKind::session_taken_over},
        {MqttReason::connection_rate_exceeded, MqttFailureKind::quota},
        {MqttReason::server_shutting_down, MqttFailureKind::unavailable},
        {MqttReason::keep_alive_timeout, MqttFailureKind::timed_out},
        {MqttReason::administrative_action, MqttFailureKind::lost},
        {MqttReason::receive_maximum_exceeded, MqttFailureKind::protocol},
    };
    for (const auto& row : rows) EXPECT_EQ(failure_kind(row.reason), row.kind) << name(row.reason);
}

TEST(MqttPort, AMessageWithoutPropertiesHasEmptyOnes) {
    MqttProperties properties;
    EXPECT_TRUE(properties.empty());
    properties.expiry_s = 0;
    EXPECT_FALSE(properties.empty());
}

}  // namespace mqtt_port_test
}  // namespace takt::publish
