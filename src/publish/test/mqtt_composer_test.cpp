#include "takt/publish/mqtt_composer.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace takt::publish {
namespace mqtt_composer_test {

constexpr std::int64_t kMillisecond = 1'000'000;

MqttComposer composer_of(model::MessageScope scope) {
    model::OutputSelection selection;
    selection.topic = *model::TopicTemplate::parse("t");
    selection.message = scope;
    model::Output output{.name = "cloud", .selections = {selection}};
    output.mqtt.control_topic = "takt/cloud";
    return {output, host::Configuration(1, {}, {})};
}

/// Texts of variables A, B, C…, read at 1 ms, 2 ms…
SampleBatch batch_of(const std::vector<std::string>& texts) {
    SampleBatch batch;
    for (const auto& text : texts) {
        const auto index = static_cast<std::uint32_t>(batch.series.size());
        const std::string name(1, static_cast<char>('A' + index));
        batch.series.push_back({name, "Meter", "line", "", DataType::string, false});
        batch.samples.push_back({.series = index, .value = text, .wall_ns = (index + 1) * kMillisecond});
    }
    return batch;
}

std::vector<ComposedMessage> compose(model::MessageScope scope, const SampleBatch& batch,
                                     const StreamPlace& place) {
    auto composer = composer_of(scope);
    std::vector<ComposedMessage> messages;
    composer.compose(batch, place, messages);
    return messages;
}

const std::string kLong(300, 'x');

TEST(MqttComposer, AGapReplacesSamplesThatAreTooLarge) {
    const auto batch = batch_of({"a", kLong, kLong, "d", kLong});
    const auto messages =
        compose(model::MessageScope::variable, batch, {.epoch = 2, .first = 11, .packet_limit = 300});
    ASSERT_EQ(messages.size(), 4U);
    EXPECT_EQ(messages[0].samples, 1U);
    EXPECT_EQ(messages[1].samples, 0U);
    EXPECT_EQ(messages[1].too_large, 2U);
    EXPECT_EQ(messages[1].message.topic, "takt/cloud/gap");
    EXPECT_FALSE(messages[1].message.retain);
    EXPECT_EQ(messages[1].message.payload,
              R"({"gap":{"cause":"too_large","samples":2,"first":"1970-01-01T00:00:00.002Z",)"
              R"("last":"1970-01-01T00:00:00.003Z"},"epoch":2,"seq":12})");
    EXPECT_EQ(messages[2].samples, 1U);
    EXPECT_EQ(messages[3].too_large, 1U);
    EXPECT_NE(messages[3].message.payload.find(R"("seq":15)"), std::string::npos);
}

TEST(MqttComposer, WithoutALimitNothingIsTooLarge) {
    const auto messages = compose(model::MessageScope::variable, batch_of({kLong}), {});
    ASSERT_EQ(messages.size(), 1U);
    EXPECT_EQ(messages[0].samples, 1U);
}

TEST(MqttComposer, AMessageOfADeviceIsSplit) {
    const auto messages = compose(model::MessageScope::device, batch_of({"a", "b", "c", kLong}),
                                  {.epoch = 2, .first = 1, .packet_limit = 340});
    ASSERT_EQ(messages.size(), 3U);
    EXPECT_EQ(messages[0].samples, 2U);
    EXPECT_EQ(messages[1].samples, 1U);
    EXPECT_EQ(messages[2].too_large, 1U);
}

// Where a message just fits without the mark, it would be another one with it.
TEST(MqttComposer, ARecordHasTheSameMessagesWhenItIsRepeated) {
    const auto batch = batch_of({"a", std::string(80, 'x'), "c"});
    for (std::size_t limit = 150; limit < 350; ++limit) {
        StreamPlace place{.epoch = 2, .first = 1, .packet_limit = limit};
        const auto first = compose(model::MessageScope::device, batch, place);
        place.repeated = MessageComposer::kMostMessages;
        const auto again = compose(model::MessageScope::device, batch, place);
        ASSERT_EQ(first.size(), again.size()) << limit;
        for (std::size_t i = 0; i < first.size(); ++i)
            ASSERT_EQ(std::pair(first[i].samples, first[i].too_large),
                      std::pair(again[i].samples, again[i].too_large));
    }
}

}  // namespace mqtt_composer_test
}  // namespace takt::publish
