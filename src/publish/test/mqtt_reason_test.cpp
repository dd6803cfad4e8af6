#include "takt/publish/mqtt_reason.hpp"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace takt::publish {
namespace mqtt_reason_test {

TEST(MqttReason, SeparatesSuccessFromFailure) {
    EXPECT_FALSE(is_failure(MqttReason::success));
    EXPECT_FALSE(is_failure(MqttReason::no_matching_subscribers));
    EXPECT_TRUE(is_failure(MqttReason::unspecified));
    EXPECT_TRUE(is_failure(MqttReason::quota_exceeded));
    EXPECT_TRUE(is_failure(MqttReason{0xFF}));
}

TEST(MqttReason, EachKnownCodeHasANameOfItsOwn) {
    std::set<std::string> names;
    int known = 0;
    for (int code = 0; code <= 0xFF; ++code) {
        const auto word = name(static_cast<MqttReason>(code));
        if (word == "unknown") continue;
        ++known;
        names.insert(std::string(word));
    }
    EXPECT_EQ(known, 32);
    EXPECT_EQ(names.size(), 32U);
}

TEST(MqttReason, ReturnCodesOf3_1_1AreConverted) {
    EXPECT_EQ(from_connack_3_1_1(0), MqttReason::success);
    EXPECT_EQ(from_connack_3_1_1(1), MqttReason::unsupported_protocol_version);
    EXPECT_EQ(from_connack_3_1_1(4), MqttReason::bad_user_name_or_password);
    EXPECT_EQ(from_connack_3_1_1(5), MqttReason::not_authorized);
    EXPECT_EQ(from_connack_3_1_1(6), MqttReason::unspecified);
}

}  // namespace mqtt_reason_test
}  // namespace takt::publish
