#include "takt/model/topic.hpp"

#include <gtest/gtest.h>

#include <string>
#include <tuple>

namespace takt::model {
namespace topic_test {

constexpr TopicNames kNames{.output = "cloud", .line = "L1", .device = "Meter", .variable = "Power"};

TEST(Topic, PlaceholdersBecomeNames) {
    const std::pair<std::string_view, std::string_view> cases[] = {
        {"takt/{output}/{line}/{device}/{variable}", "takt/cloud/L1/Meter/Power"},
        {"{device}-{variable}", "Meter-Power"},
        {"plain", "plain"},
        {"devices/x/messages/events/", "devices/x/messages/events/"},
        {"{variable}", "Power"},
        {"$aws/rules/{device}", "$aws/rules/Meter"},
    };
    for (const auto& [text, topic] : cases) {
        const auto parsed = TopicTemplate::parse(text);
        ASSERT_TRUE(parsed) << text;
        EXPECT_EQ(parsed->expand(kNames), topic);
    }
}

TEST(Topic, ANameIsOneLevel) {
    const auto parsed = TopicTemplate::parse("{device}/{variable}");
    ASSERT_TRUE(parsed);
    EXPECT_EQ(parsed->expand({.device = "a/b", .variable = "+#\x01 \x7Fü"}), "a_b/___ _ü");
    EXPECT_TRUE(parsed->has(TopicPart::device));
    EXPECT_FALSE(parsed->has(TopicPart::line));
}

TEST(Topic, OthersAreRejected) {
    const std::tuple<std::string_view, TopicError, std::string_view> cases[] = {
        {"a/{tag}/b", TopicError::unknown_part, "{tag}"},
        {"a/{}", TopicError::unknown_part, "{}"},
        {"a/{ device }", TopicError::unknown_part, "{ device }"},
        {"a/{device", TopicError::brace, ""},
        {"a/device}", TopicError::brace, ""},
        {"a/{{device}}", TopicError::brace, ""},
        {"a/+/b", TopicError::wildcard, ""},
        {"a/#", TopicError::wildcard, ""},
        {"/a", TopicError::empty_level, ""},
        {"a//b", TopicError::empty_level, ""},
        {"a//", TopicError::empty_level, ""},
        {"/", TopicError::empty_level, ""},
        {"", TopicError::empty_level, ""},
    };
    for (const auto& [text, error, part] : cases) {
        const auto parsed = TopicTemplate::parse(text);
        ASSERT_FALSE(parsed) << text;
        EXPECT_EQ(parsed.error().error, error) << text;
        EXPECT_EQ(parsed.error().part, part) << text;
    }
}

}  // namespace topic_test
}  // namespace takt::model
