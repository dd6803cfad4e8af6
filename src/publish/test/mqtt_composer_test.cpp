#include "takt/publish/mqtt_composer.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "mqtt/mqtt_packet.hpp"

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
    const std::vector<RecordSamples> portion{{batch, place.first}};
    composer.compose(portion, place, messages);
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

/// Texts of one variable on a topic of its own, in a record each.
class Arrays : public testing::Test {
protected:
    std::vector<ComposedMessage> compose(const StreamPlace& place) {
        model::OutputSelection selection;
        selection.topic =
            *model::TopicTemplate::parse(scope_ == model::MessageScope::variable ? "t/{variable}" : "t");
        selection.message = scope_;
        selection.retain = retain_;
        model::Output output{.name = "cloud", .selections = {selection}};
        output.mqtt.control_topic = "takt/cloud";
        output.mqtt.backlog = model::Backlog::array;
        MqttComposer composer(output, host::Configuration(1, {}, {}));
        EXPECT_TRUE(composer.joins_records());
        std::vector<ComposedMessage> messages;
        composer.compose(portion_, place, messages);
        return messages;
    }
    void add(const std::vector<std::string>& texts) {
        portion_.push_back({batch_of(texts), next_});
        next_ += texts.size();
    }

    model::MessageScope scope_ = model::MessageScope::variable;
    bool retain_ = false;
    std::vector<RecordSamples> portion_;
    std::uint64_t next_ = 1;
};

/// The numbers of the samples in a payload.
std::string numbers_in(const std::string& payload) {
    std::string numbers;
    for (auto at = payload.find("\"seq\":"); at != std::string::npos; at = payload.find("\"seq\":", at + 1)) {
        const auto begin = at + 6;
        numbers +=
            (numbers.empty() ? "" : " ") + payload.substr(begin, payload.find_first_of(",}", begin) - begin);
    }
    return numbers;
}

TEST_F(Arrays, CarryWhatWaitsAndTheLastSampleOfATopicTravelsAlone) {
    add({"a"});
    add({"b", "c"});
    add({"d", "e"});
    const auto messages = compose({.epoch = 2});
    ASSERT_EQ(messages.size(), 4U);
    const std::string expected[] = {"1 2", "3", "4", "5"};
    for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(numbers_in(messages[i].message.payload), expected[i]);
    EXPECT_TRUE(messages[0].message.payload.starts_with("[{")) << messages[0].message.payload;
    EXPECT_TRUE(messages[0].message.payload.ends_with("}]"));
    EXPECT_EQ(messages[0].samples, 2U);
    EXPECT_EQ(messages[0].message.topic, "t/A");
    EXPECT_TRUE(messages[1].message.payload.starts_with("{"));
}

TEST_F(Arrays, RetainedTopicsCarryOneSampleEach) {
    retain_ = true;
    for (int i = 0; i < 5; ++i) add({"a"});
    const auto messages = compose({.epoch = 2});
    ASSERT_EQ(messages.size(), 5U);
    for (const auto& message : messages) EXPECT_EQ(message.samples, 1U);
}

TEST_F(Arrays, OfDevicesCarryMessagesOfDevices) {
    scope_ = model::MessageScope::device;
    for (int i = 0; i < 3; ++i) add({"a", "b"});
    const auto messages = compose({.epoch = 2});
    ASSERT_EQ(messages.size(), 2U);
    EXPECT_EQ(numbers_in(messages[0].message.payload), "1 2 3 4");
    EXPECT_EQ(messages[0].samples, 4U);
    EXPECT_EQ(messages[1].samples, 2U);
}

TEST_F(Arrays, AreAsLongAsAPacketAndNoLonger) {
    for (int i = 0; i < 40; ++i) add({std::string(static_cast<std::size_t>(i % 7), 'x')});
    for (const std::size_t limit :
         {std::size_t{1'000}, std::size_t{1'001}, std::size_t{3'000}, std::size_t{200'000}}) {
        std::size_t samples = 0;
        std::size_t arrays = 0;
        for (const bool repeated : {false, true}) {
            const auto messages = compose({.epoch = 2,
                                           .repeated = repeated ? MessageComposer::kMostMessages : 0,
                                           .packet_limit = limit});
            for (const auto& [message, count, too_large] : messages) {
                EXPECT_LE(publish_packet_size(message, MqttVersion::v5), limit);
                samples += count;
                if (count > 1) ++arrays;
            }
        }
        EXPECT_EQ(samples, 80U);
        EXPECT_EQ(arrays, 2 * (limit == 200'000 ? 1 : limit == 3'000 ? 2 : 7)) << limit;
    }
}

TEST_F(Arrays, HaveALimitWhereTheBrokerAnnouncesNone) {
    for (int i = 0; i < 1'000; ++i) add({"some text"});
    std::size_t samples = 0;
    for (const auto& [message, count, too_large] : compose({.epoch = 2})) {
        EXPECT_LE(publish_packet_size(message, MqttVersion::v5), MqttComposer::kLongestArray);
        samples += count;
    }
    EXPECT_EQ(samples, 1'000U);
}

TEST_F(Arrays, AGapReplacesASampleThatIsTooLargeAlone) {
    const std::string long_text(600, 'x');
    for (const auto& text :
         {std::string("a"), std::string("b"), long_text, long_text, std::string("e"), std::string("f")})
        add({text});
    const auto messages = compose({.epoch = 2, .packet_limit = 700});
    ASSERT_EQ(messages.size(), 3U);
    EXPECT_EQ(numbers_in(messages[0].message.payload), "1 2 5");
    EXPECT_EQ(messages[1].too_large, 2U);
    EXPECT_NE(messages[1].message.payload.find(R"("seq":3)"), std::string::npos);
    EXPECT_EQ(numbers_in(messages[2].message.payload), "6");
}

}  // namespace mqtt_composer_test
}  // namespace takt::publish
