#include "mqtt/mqtt_packet.hpp"

#include <gtest/gtest.h>

#include <string>

namespace takt::publish {
namespace mqtt_packet_test {

constexpr std::size_t kNoLimit = SIZE_MAX;

TEST(MqttPacket, ItsSizeIsThatOfTheStandard) {
    // 30 07 00 01 61 (0) ... : type and flags, length, topic "a", packet identifier, payload
    EXPECT_EQ(publish_packet_size({.topic = "a", .payload = "xy", .qos = 0}, MqttVersion::v3_1_1), 7U);
    EXPECT_EQ(publish_packet_size({.topic = "a", .payload = "xy", .qos = 1}, MqttVersion::v3_1_1), 9U);
    EXPECT_EQ(publish_packet_size({.topic = "a", .payload = "xy", .qos = 1}, MqttVersion::v5), 10U);
    MqttMessage message{.topic = "a", .payload = "xy", .qos = 1};
    message.properties.expiry_s = 10;               // 5
    message.properties.response_topic = "r";        // 4
    message.properties.user = {{"name", "value"}};  // 14
    EXPECT_EQ(publish_packet_size(message, MqttVersion::v5), 33U);
    EXPECT_EQ(publish_packet_size(message, MqttVersion::v3_1_1), 9U);
}

TEST(MqttPacket, TheLengthFieldGrowsWithTheLength) {
    for (const std::size_t remaining : {127U, 128U, 16'383U, 16'384U, 2'097'151U, 2'097'152U}) {
        const std::size_t field = remaining < 128         ? 1
                                  : remaining < 16'384    ? 2
                                  : remaining < 2'097'152 ? 3
                                                          : 4;
        const MqttMessage message{.topic = "a", .payload = std::string(remaining - 3, 'x'), .qos = 0};
        EXPECT_EQ(publish_packet_size(message, MqttVersion::v3_1_1), 1 + field + remaining);
    }
}

TEST(MqttPacket, ATopicNameHasNoWildcardsAndNoControlCharacters) {
    EXPECT_TRUE(is_topic_name("site/line/device"));
    EXPECT_TRUE(is_topic_name("цех/насос 1"));
    EXPECT_TRUE(is_topic_name(std::string(65'535, 'a')));
    EXPECT_FALSE(is_topic_name(std::string(65'536, 'a')));
    EXPECT_FALSE(is_topic_name(""));
    EXPECT_FALSE(is_topic_name("a/+/b"));
    EXPECT_FALSE(is_topic_name("a/#"));
    EXPECT_FALSE(is_topic_name(std::string_view("a\0b", 3)));
    EXPECT_FALSE(is_topic_name("a\nb"));
    EXPECT_FALSE(is_topic_name("a\xC3"));
    EXPECT_FALSE(is_topic_name("\xEF\xBF\xBF"));  // U+FFFF
}

TEST(MqttPacket, AMessageThatCanNeverBeSentHasAReason) {
    MqttMessage good{.topic = "t", .payload = "12345"};
    EXPECT_EQ(reason_not_to_send(good, MqttVersion::v5, kNoLimit), MqttReason::success);
    const std::size_t size = publish_packet_size(good, MqttVersion::v5);
    EXPECT_EQ(reason_not_to_send(good, MqttVersion::v5, size), MqttReason::success);
    EXPECT_EQ(reason_not_to_send(good, MqttVersion::v5, size - 1), MqttReason::packet_too_large);

    EXPECT_EQ(reason_not_to_send({.topic = "t/#"}, MqttVersion::v5, kNoLimit),
              MqttReason::topic_name_invalid);
    MqttMessage answer = good;
    answer.properties.response_topic = "r/+";
    EXPECT_EQ(reason_not_to_send(answer, MqttVersion::v5, kNoLimit), MqttReason::topic_name_invalid);
    EXPECT_EQ(reason_not_to_send(answer, MqttVersion::v3_1_1, kNoLimit), MqttReason::success)
        << "3.1.1 has no properties";
    MqttMessage odd = good;
    odd.properties.user = {{"n", "\xFF"}};
    EXPECT_EQ(reason_not_to_send(odd, MqttVersion::v5, kNoLimit), MqttReason::payload_format_invalid);
}

}  // namespace mqtt_packet_test
}  // namespace takt::publish
