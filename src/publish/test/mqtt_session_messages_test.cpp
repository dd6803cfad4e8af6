// Messages of a session: the window, acknowledgements in any order, refusals, live messages.
#include <gtest/gtest.h>

#include <string>

#include "session_rig.hpp"

namespace takt::publish {
namespace mqtt_session_messages_test {

struct MqttSessionMessages : testing::Test, SessionRig {
    /// Connected, with `messages` in the source.
    void connected_with(std::uint64_t messages, MqttConnected answer = {}) {
        source.count = messages;
        start();
        accept(answer);
    }
};

TEST_F(MqttSessionMessages, AreSentInOrderAsFarAsTheWindowGoes) {
    options.window = 3;
    connected_with(5);
    EXPECT_EQ(published(), "1 2 3");
    EXPECT_EQ(status().in_flight, 3U);
    acknowledge({"1"});
    EXPECT_EQ(published(), "4");
    acknowledge({"2", "3", "4"});
    EXPECT_EQ(published(), "5");
    acknowledge({"5"});
    EXPECT_EQ(source.cursor, 5U);
    EXPECT_EQ(status().counters.acknowledged, 5U);
    produce(1);
    EXPECT_EQ(published(), "6");
}

TEST_F(MqttSessionMessages, TheCursorMovesInOrderAlthoughAcknowledgementsDoNot) {
    options.window = 4;
    connected_with(4);
    EXPECT_EQ(published(), "1 2 3 4");
    acknowledge({"3", "2"});
    EXPECT_EQ(source.cursor, 0U);
    produce(2);
    EXPECT_EQ(published(), "") << "no more than a window behind the cursor";
    acknowledge({"1"});
    EXPECT_EQ(source.cursor, 3U);
    EXPECT_EQ(published(), "5 6");
    acknowledge({"4", "4"});
    EXPECT_EQ(source.cursor, 4U) << "a second acknowledgement has no effect";
}

TEST_F(MqttSessionMessages, ReceiveMaximumLimitsTheWindow) {
    connected_with(3, {.receive_maximum = 1});
    EXPECT_EQ(status().window, 1U);
    for (const char* number : {"1", "2", "3"}) {
        EXPECT_EQ(published(), number);
        acknowledge({number});
    }
    EXPECT_EQ(source.cursor, 3U);
}

TEST_F(MqttSessionMessages, AfterALossEverythingNotAcknowledgedIsSentAgainInOrder) {
    for (unsigned acknowledged = 0; acknowledged <= 4; ++acknowledged) {
        SessionRig rig;
        rig.options.window = 4;
        rig.source.count = 4;
        rig.start();
        rig.accept();
        EXPECT_EQ(rig.published(), "1 2 3 4");
        for (unsigned number = 1; number <= acknowledged; ++number) rig.acknowledge({std::to_string(number)});
        rig.close(MqttFailureKind::lost);
        rig.advance(1s);
        rig.accept();
        std::string rest;
        for (unsigned number = acknowledged + 1; number <= 4; ++number)
            rest += (rest.empty() ? "" : " ") + std::to_string(number);
        EXPECT_EQ(rig.published(), rest);
        EXPECT_EQ(rig.status().counters.repeated, 4U - acknowledged);
        EXPECT_EQ(rig.status().counters.published, 8U - acknowledged);
        EXPECT_EQ(rig.status().counters.lost_connections, 1U);
    }
}

TEST_F(MqttSessionMessages, AnAcknowledgementOfAnEarlierConnectionIsIgnored) {
    connected_with(1);
    EXPECT_EQ(published(), "1");
    const auto old = connection;
    close(MqttFailureKind::lost);
    event(MqttAcknowledged{old, tokens.at("1"), {}});
    EXPECT_EQ(source.cursor, 0U);
    advance(1s);
    accept();
    event(MqttAcknowledged{old, tokens.at("1"), {}});
    EXPECT_EQ(source.cursor, 0U);
    EXPECT_EQ(published(), "1");
}

TEST_F(MqttSessionMessages, WithoutSubscribersAMessageCountsAsDelivered) {
    connected_with(1);
    EXPECT_EQ(published(), "1");
    acknowledge({"1"}, MqttReason::no_matching_subscribers);
    EXPECT_EQ(source.cursor, 1U);
    EXPECT_EQ(status().counters.no_subscribers, 1U);
    EXPECT_EQ(status().counters.acknowledged, 1U);
}

TEST_F(MqttSessionMessages, ARefusedMessageIsSentAgainAfterAPauseAndSlowly) {
    options.window = 3;
    connected_with(6);
    EXPECT_EQ(published(), "1 2 3");
    acknowledge({"1"});
    EXPECT_EQ(published(), "4");
    acknowledge({"2"}, MqttReason::quota_exceeded);
    acknowledge({"3", "4"});
    EXPECT_EQ(source.cursor, 1U);
    EXPECT_TRUE(status().refusing) << "other messages prove nothing";
    EXPECT_EQ(status().failure->kind, MqttFailureKind::quota);
    EXPECT_EQ(published(), "");
    advance(999ms);
    EXPECT_EQ(published(), "");
    advance(1ms);
    EXPECT_EQ(published(), "2") << "one message at first";
    acknowledge({"2"});
    EXPECT_FALSE(status().refusing);
    EXPECT_FALSE(status().failure);
    EXPECT_EQ(published(), "3 4");
    acknowledge({"3"});
    EXPECT_EQ(published(), "5 6") << "the window has its size again";
    EXPECT_EQ(status().counters.refused, 1U);
    EXPECT_EQ(status().counters.repeated, 3U);
    EXPECT_EQ(status().last_failure->kind, MqttFailureKind::quota);
}

TEST_F(MqttSessionMessages, ThePauseAfterRefusalsDoublesUpToItsLimit) {
    options.longest_pause = 4s;
    connected_with(1);
    for (const Duration pause : {1s, 2s, 4s, 4s}) {
        EXPECT_EQ(published(), "1");
        acknowledge({"1"}, MqttReason::not_authorized);
        advance(pause - 1ms);
        EXPECT_EQ(published(), "");
        advance(1ms);
    }
    EXPECT_EQ(published(), "1");
    acknowledge({"1"});
    EXPECT_EQ(source.cursor, 1U);
    EXPECT_EQ(status().counters.refused, 4U);
}

TEST_F(MqttSessionMessages, OneThatCanNeverBeSentIsRejectedInOrder) {
    options.window = 4;
    source.adapt = [](MqttMessage& message, std::uint64_t number) {
        if (number == 2) message.topic = "data/#";
        if (number == 3) message.payload = std::string(200, 'x');
    };
    connected_with(4, {.maximum_packet = 100});
    EXPECT_EQ(source.limits.packet, 100U);
    EXPECT_EQ(published(), "1 4");
    EXPECT_TRUE(source.rejected.empty()) << "1 is not acknowledged";
    acknowledge({"4"});
    acknowledge({"1"});
    EXPECT_EQ(source.cursor, 4U);
    EXPECT_EQ(source.rejected, (std::map<std::uint64_t, MqttReason>{{2, MqttReason::topic_name_invalid},
                                                                    {3, MqttReason::packet_too_large}}));
    EXPECT_EQ(status().counters.rejected, 2U);
}

TEST_F(MqttSessionMessages, TheBrokerMayRejectAMessageForEver) {
    for (const auto reason :
         {MqttReason::packet_too_large, MqttReason::topic_name_invalid, MqttReason::payload_format_invalid}) {
        SessionRig rig;
        rig.source.count = 2;
        rig.start();
        rig.accept();
        EXPECT_EQ(rig.published(), "1 2");
        rig.acknowledge({"1"}, reason);
        rig.acknowledge({"2"});
        EXPECT_EQ(rig.source.cursor, 2U);
        EXPECT_EQ(rig.source.rejected.at(1), reason);
        EXPECT_EQ(rig.status().counters.rejected, 1U);
    }
}

TEST_F(MqttSessionMessages, ABrokerOfQos0GetsQos0AndTheStatusSaysSo) {
    source.count = 1;
    start();
    accept({.maximum_qos = 0});
    const auto publish = expect<MqttPublish>();
    EXPECT_EQ(publish.message.qos, 0);
    EXPECT_TRUE(status().qos_0_only);
    event(MqttAcknowledged{connection, publish.token, {}});
    EXPECT_EQ(source.cursor, 1U);
    EXPECT_EQ(status().counters.unproved, 1U);
    EXPECT_EQ(status().counters.acknowledged, 0U);
}

TEST_F(MqttSessionMessages, ABrokerWithoutRetainedMessagesGetsNone) {
    source.adapt = [](MqttMessage& message, std::uint64_t) { message.retain = true; };
    connected_with(1, {.retain_available = false});
    EXPECT_FALSE(expect<MqttPublish>().message.retain);
    EXPECT_TRUE(status().retain_unavailable);
}

TEST_F(MqttSessionMessages, LiveOnesGoFirstAndShareTheWindow) {
    options.window = 2;
    connected_with(3);
    EXPECT_EQ(published(), "1 2");
    EXPECT_TRUE(publish({.message = {.topic = "state", .payload = "a"}}));
    EXPECT_TRUE(publish({.message = {.topic = "state", .payload = "b"}}));
    acknowledge({"1"});
    EXPECT_EQ(published(), "a");
    acknowledge({"a"});
    EXPECT_EQ(published(), "b");
    acknowledge({"2"});
    EXPECT_EQ(published(), "3");
    EXPECT_EQ(status().counters.live_published, 1U);
}

TEST_F(MqttSessionMessages, TheLiveQueueIsBounded) {
    options.live_queue = 2;
    EXPECT_TRUE(publish({.message = {.topic = "state", .payload = "a"}}));
    EXPECT_TRUE(publish({.message = {.topic = "state", .payload = "b"}}));
    EXPECT_FALSE(publish({.message = {.topic = "state", .payload = "c"}}));
    EXPECT_FALSE(publish({.message = {.topic = "state/#", .payload = "d"}}));
    EXPECT_EQ(status().counters.live_dropped, 2U);
    EXPECT_EQ(status().live_waiting, 2U);
}

TEST_F(MqttSessionMessages, ALiveOneBeyondThePacketLimitIsSentShort) {
    connected_with(0, {.maximum_packet = 100});
    const std::string large(200, 'x');
    publish({.message = {.topic = "answer", .payload = "whole"}, .short_payload = "short of whole"});
    publish({.message = {.topic = "answer", .payload = large}, .short_payload = "short"});
    publish({.message = {.topic = "answer", .payload = large}, .short_payload = large});
    publish({.message = {.topic = "answer", .payload = large}});
    EXPECT_EQ(published(), "whole short");
    EXPECT_EQ(status().counters.live_dropped, 2U);
}

TEST_F(MqttSessionMessages, ALiveOneSurvivesALostConnectionUntilItExpires) {
    connected_with(0);
    publish({.message = {.topic = "answer", .payload = "short"}, .expires = now + 500ms});
    publish({.message = {.topic = "answer", .payload = "long"}, .expires = now + 1min});
    publish({.message = {.topic = "state", .payload = "state"}, .this_connection_only = true});
    EXPECT_EQ(published(), "short long state");
    close(MqttFailureKind::lost);
    EXPECT_FALSE(publish({.message = {.topic = "state", .payload = "x"}, .this_connection_only = true}));
    advance(1s);
    accept();
    EXPECT_EQ(published(), "long");
    acknowledge({"long"});
    EXPECT_EQ(status().live_waiting, 0U);
    EXPECT_EQ(status().counters.live_dropped, 3U);
}

TEST_F(MqttSessionMessages, ALiveOneIsSentAgainAfterAQuotaAndDroppedAfterAnotherRefusal) {
    connected_with(0);
    publish({.message = {.topic = "answer", .payload = "a"}});
    publish({.message = {.topic = "answer", .payload = "b"}});
    EXPECT_EQ(published(), "a b");
    acknowledge({"a"}, MqttReason::quota_exceeded);
    acknowledge({"b"}, MqttReason::not_authorized);
    advance(1s);
    EXPECT_EQ(published(), "a");
    EXPECT_EQ(status().counters.live_dropped, 1U);
    EXPECT_EQ(status().last_failure->kind, MqttFailureKind::not_authorized);
}

TEST_F(MqttSessionMessages, AHalfOpenConnectionIsReplaced) {
    connected_with(2);
    EXPECT_EQ(published(), "1 2");
    advance(20s);
    acknowledge({"1"});
    advance(29s);
    EXPECT_TRUE(actions.empty());
    advance(1s);
    EXPECT_FALSE(expect<MqttDisconnect>().orderly) << "the broker publishes the will";
    EXPECT_TRUE(actions.empty()) << "the new connection waits for the end of the old one";
    close(MqttFailureKind::none);
    EXPECT_EQ(status().last_failure->kind, MqttFailureKind::timed_out);
    advance(1s);
    accept();
    EXPECT_EQ(published(), "2");
}

// The broker goes on to answer, so that the link is alive, but the cursor cannot move.
TEST_F(MqttSessionMessages, AConnectionThatLostAnAcknowledgementIsReplaced) {
    options.answer_timeout = 30s;
    start();
    accept();
    produce(3);
    EXPECT_EQ(published(), "1 2 3");
    acknowledge({"2", "3"});
    for (int i = 0; i < 29; ++i) {
        advance(1s);
        ASSERT_TRUE(publish({.message = {.topic = "state", .payload = "live"}}));
        EXPECT_EQ(published(), "live");
        acknowledge({"live"});
    }
    EXPECT_TRUE(actions.empty());
    advance(1s);
    EXPECT_FALSE(expect<MqttDisconnect>().orderly);
    close(MqttFailureKind::none);
    EXPECT_EQ(status().last_failure->kind, MqttFailureKind::timed_out);
    until_attempt();
    accept();
    EXPECT_EQ(published(), "1 2 3");
}

TEST_F(MqttSessionMessages, AnIdleConnectionIsNotReplaced) {
    connected_with(1);
    EXPECT_EQ(published(), "1");
    acknowledge({"1"});
    advance(24h);
    EXPECT_TRUE(actions.empty());
    produce(1);
    EXPECT_EQ(published(), "2");
    advance(29s);
    EXPECT_TRUE(actions.empty()) << "the time counts from the first message after the pause";
}

TEST_F(MqttSessionMessages, TheRoundTripIsThatOfAcknowledgements) {
    start();
    accept();
    EXPECT_EQ(status().round_trip, std::nullopt);
    produce(2);
    published();
    now += 100ms;
    acknowledge({"1"});
    EXPECT_EQ(status().round_trip, 100ms);
    now += 80ms;
    acknowledge({"2"});
    EXPECT_EQ(status().round_trip, 110ms) << "smoothed";
    close(MqttFailureKind::lost);
    EXPECT_EQ(status().round_trip, std::nullopt);
}

}  // namespace mqtt_session_messages_test
}  // namespace takt::publish
