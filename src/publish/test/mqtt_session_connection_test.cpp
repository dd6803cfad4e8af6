// Connections of a session: attempts, pauses, versions, brokers, birth and will, subscriptions, the end.
#include <gtest/gtest.h>

#include <string>

#include "session_rig.hpp"

namespace takt::publish {
namespace mqtt_session_connection_test {

struct MqttSessionConnection : testing::Test, SessionRig {
    std::string host_of_attempt(MqttFailureKind kind = MqttFailureKind::refused) {
        return fail(kind).broker.host;
    }
};

TEST_F(MqttSessionConnection, TheStatesOfAnAttempt) {
    EXPECT_EQ(status().state, MqttState::off);
    EXPECT_EQ(session().next_wakeup(), kNever);
    start();
    EXPECT_EQ(status().state, MqttState::connecting);
    accept();
    EXPECT_EQ(status().state, MqttState::connected);
    EXPECT_EQ(status().since, now);
    EXPECT_EQ(status().version, MqttVersion::v5);
    EXPECT_EQ(connected, std::vector{connection});
    const Instant began = now;
    advance(30s);
    EXPECT_EQ(status().since, began);
    close(MqttFailureKind::lost);
    EXPECT_EQ(disconnected, std::vector{connection});
    EXPECT_EQ(status().state, MqttState::backing_off);
    EXPECT_EQ(status().since, now);
    EXPECT_GT(status().next_attempt, now);
    EXPECT_EQ(status().version, std::nullopt);
    EXPECT_EQ(status().last_failure->kind, MqttFailureKind::lost);
}

TEST_F(MqttSessionConnection, ConnectCarriesWhatTheUserSet) {
    options.user = "user";
    options.password = "password";
    options.keep_alive = 45s;
    options.will = {.topic = "state", .payload = "offline", .retain = true};
    start();
    const auto connect = accept({.server_keep_alive = 20});
    EXPECT_EQ(connect.client_id, "takt");
    EXPECT_EQ(connect.user, "user");
    EXPECT_EQ(connect.password, "password");
    EXPECT_EQ(connect.keep_alive, 45s);
    EXPECT_EQ(connect.will, options.will);
    EXPECT_EQ(status().keep_alive, 20s) << "the broker's";
}

TEST_F(MqttSessionConnection, PausesDoubleUpToTheirLimitAndAreUpToHalfShorter) {
    options.versions = MqttVersions::only_5;
    start();
    for (const Duration longest : {1s, 2s, 4s, 8s, 16s, 32s, 60s, 60s}) {
        fail(MqttFailureKind::refused);
        const Duration pause = until_attempt();
        EXPECT_LE(pause, longest);
        EXPECT_GE(pause, longest / 2);
    }
    EXPECT_EQ(status().counters.attempts, 9U);
}

TEST_F(MqttSessionConnection, PausesAreShortWhereNoProgramAnswersNearby) {
    const auto longest_pause = [](MqttFailureKind kind, bool nearby) {
        SessionRig rig;
        rig.options.versions = MqttVersions::only_5;
        rig.start();
        Duration longest{};
        for (int i = 0; i < 20; ++i) {
            rig.connection = rig.expect<MqttConnect>().connection;
            rig.event(MqttClosed{rig.connection, {kind, {}, {}}, nearby});
            longest = std::max(longest, rig.until_attempt());
        }
        return longest;
    };
    for (const auto kind :
         {MqttFailureKind::refused, MqttFailureKind::unreachable, MqttFailureKind::timed_out}) {
        EXPECT_LE(longest_pause(kind, true), 10s) << name(kind);
        EXPECT_GT(longest_pause(kind, true), 5s);
        EXPECT_GT(longest_pause(kind, false), 30s);
    }
    for (const auto kind : {MqttFailureKind::not_authorized, MqttFailureKind::lost,
                            MqttFailureKind::unavailable, MqttFailureKind::tls, MqttFailureKind::dns})
        EXPECT_GT(longest_pause(kind, true), 30s) << name(kind);
}

TEST_F(MqttSessionConnection, ShortConnectionsAndTakeoversKeepTheirPausesNearby) {
    options.versions = MqttVersions::only_5;
    start();
    for (int i = 0; i < 8; ++i) {
        accept();
        event(MqttClosed{connection, {MqttFailureKind::lost, {}, {}}, true});
        const Duration pause = until_attempt();
        if (i == 7) EXPECT_GT(pause, 30s);
    }
    connection = expect<MqttConnect>().connection;
    event(MqttClosed{connection, {MqttFailureKind::refused, {}, {}}, true});
    EXPECT_LE(until_attempt(), 10s);
    accept();
    event(MqttClosed{
        connection, {MqttFailureKind::session_taken_over, MqttReason::session_taken_over, {}}, true});
    EXPECT_EQ(status().state, MqttState::stopped);
    EXPECT_GT(until_attempt(), 4min);
}

TEST_F(MqttSessionConnection, OneBrokerThatIsNotNearbyMakesTheRoundLong) {
    options.versions = MqttVersions::only_5;
    options.brokers = {{.host = "near"}, {.host = "far"}};
    start();
    Duration longest{};
    for (int i = 0; i < 20; ++i) {
        for (const bool nearby : {true, false}) {
            connection = expect<MqttConnect>().connection;
            event(MqttClosed{connection, {MqttFailureKind::refused, {}, {}}, nearby});
        }
        longest = std::max(longest, until_attempt());
    }
    EXPECT_GT(longest, 30s);
}

TEST_F(MqttSessionConnection, TheJitterComesFromTheSeed) {
    const auto pauses = [](std::uint64_t seed) {
        SessionRig rig;
        rig.options.seed = seed;
        rig.start();
        std::vector<Duration> all;
        for (int i = 0; i < 5; ++i) {
            rig.fail(MqttFailureKind::refused);
            all.push_back(rig.until_attempt());
        }
        return all;
    };
    EXPECT_EQ(pauses(1), pauses(1));
    EXPECT_NE(pauses(1), pauses(2));
}

TEST_F(MqttSessionConnection, AStableConnectionMakesThePauseShortAgain) {
    options.versions = MqttVersions::only_5;
    for (const Duration life : {1s, 10s}) {
        SessionRig rig;
        rig.options = options;
        rig.start();
        for (int i = 0; i < 4; ++i) {
            rig.fail(MqttFailureKind::refused);
            rig.until_attempt();
        }
        rig.accept();
        rig.advance(life);
        rig.close(MqttFailureKind::lost);
        const Duration pause = rig.status().next_attempt - rig.now;
        if (life < options.stable_after)
            EXPECT_GE(pause, 8s);
        else
            EXPECT_LE(pause, 1s);
    }
}

TEST_F(MqttSessionConnection, AFailureThatAUserMustClearWaitsLonger) {
    for (const auto kind :
         {MqttFailureKind::not_authorized, MqttFailureKind::tls_expired, MqttFailureKind::tls_unknown_issuer,
          MqttFailureKind::tls_other_name, MqttFailureKind::quota}) {
        SessionRig rig;
        rig.options.refused_pause = 30s;
        rig.start();
        rig.fail(kind, MqttReason::not_authorized);
        EXPECT_GE(rig.until_attempt(), 30s) << name(kind);
    }
}

TEST_F(MqttSessionConnection, AnAttemptWithoutAnAnswerTimesOut) {
    options.connect_timeout = 5s;
    options.versions = MqttVersions::only_5;
    start();
    connection = expect<MqttConnect>().connection;
    advance(5s);
    EXPECT_EQ(expect<MqttDisconnect>().connection, connection);
    advance(1h);
    EXPECT_TRUE(actions.empty()) << "no second connection before the end of the first one";
    event(MqttConnected{.connection = connection});
    EXPECT_TRUE(connected.empty()) << "too late";
    close(MqttFailureKind::none);
    EXPECT_EQ(status().last_failure->kind, MqttFailureKind::timed_out);
    EXPECT_LE(until_attempt(), 1s);
    EXPECT_GT(expect<MqttConnect>().connection, connection);
}

TEST_F(MqttSessionConnection, BrokersAreTriedInOrderAndAPauseFollowsTheLast) {
    options.brokers = {{.host = "a"}, {.host = "b"}, {.host = "c"}};
    start();
    EXPECT_EQ(host_of_attempt(), "a");
    EXPECT_EQ(host_of_attempt(), "b");
    EXPECT_EQ(host_of_attempt(), "c");
    EXPECT_TRUE(actions.empty());
    EXPECT_GE(until_attempt(), 500ms);
    EXPECT_EQ(host_of_attempt(), "a");
    EXPECT_EQ(accept().broker.host, "b");
    EXPECT_EQ(status().broker, 1U);
    close(MqttFailureKind::lost);
    until_attempt();
    EXPECT_EQ(accept().broker.host, "a") << "the preferred one first";
}

TEST_F(MqttSessionConnection, TheSessionReturnsToThePreferredBroker) {
    options.brokers = {{.host = "a"}, {.host = "b"}};
    options.return_after = 10min;
    options.will = {.topic = "state", .payload = "offline"};
    source.count = 2;
    start();
    EXPECT_EQ(host_of_attempt(), "a");
    EXPECT_EQ(accept().broker.host, "b");
    EXPECT_EQ(published(), "1 2");
    acknowledge({"1", "2"});
    advance(10min - 1s);
    EXPECT_TRUE(actions.empty());
    produce(2);
    EXPECT_EQ(published(), "3 4");
    advance(1s);
    EXPECT_EQ(status().state, MqttState::leaving);
    produce(1);
    EXPECT_TRUE(actions.empty()) << "nothing more is sent, and the answers are awaited";
    acknowledge({"3", "4"});
    EXPECT_EQ(published(), "offline");
    acknowledge({"offline"});
    EXPECT_TRUE(expect<MqttDisconnect>().orderly);
    close(MqttFailureKind::none);
    EXPECT_EQ(accept().broker.host, "a") << "without a pause";
    EXPECT_EQ(published(), "5") << "nothing was repeated";
    EXPECT_EQ(status().counters.repeated, 0U);
    EXPECT_EQ(status().counters.lost_connections, 0U);
    advance(24h);
    EXPECT_NE(status().state, MqttState::leaving);
}

TEST_F(MqttSessionConnection, AttemptsToReturnBecomeRarer) {
    options.brokers = {{.host = "a"}, {.host = "b"}};
    options.return_after = 10min;
    start();
    fail(MqttFailureKind::refused);
    for (const Duration stay : {10min, 20min, 40min, 80min, 80min}) {
        accept();
        advance(stay - 1s);
        EXPECT_TRUE(actions.empty());
        advance(1s);
        expect<MqttDisconnect>();
        close(MqttFailureKind::none);
        EXPECT_EQ(host_of_attempt(), "a");
    }
    EXPECT_EQ(accept().broker.host, "b");
}

TEST_F(MqttSessionConnection, Version3_1_1FollowsWhere5IsRefused) {
    const struct {
        MqttFailureKind kind;
        MqttReason reason;
        bool other_version;
    } rows[] = {{MqttFailureKind::version, MqttReason::unsupported_protocol_version, true},
                {MqttFailureKind::lost, MqttReason::success, true},
                {MqttFailureKind::protocol, MqttReason::success, true},
                {MqttFailureKind::protocol, MqttReason::malformed_packet, false},
                {MqttFailureKind::refused, MqttReason::success, false},
                {MqttFailureKind::not_authorized, MqttReason::not_authorized, false}};
    for (const auto& row : rows) {
        SessionRig rig;
        rig.start();
        EXPECT_EQ(rig.fail(row.kind, row.reason).version, MqttVersion::v5);
        EXPECT_EQ(!rig.actions.empty(), row.other_version) << name(row.kind);
        if (rig.actions.empty()) continue;
        EXPECT_EQ(rig.accept().version, MqttVersion::v3_1_1);
        EXPECT_EQ(rig.status().version, MqttVersion::v3_1_1);
    }
}

TEST_F(MqttSessionConnection, TheVersionIsRememberedForEachBroker) {
    options.brokers = {{.host = "old"}, {.host = "new"}};
    start();
    EXPECT_EQ(fail(MqttFailureKind::version).version, MqttVersion::v5);
    EXPECT_EQ(accept().version, MqttVersion::v3_1_1);
    close(MqttFailureKind::lost);
    until_attempt();
    const auto again = fail(MqttFailureKind::refused);
    EXPECT_EQ(again.broker.host, "old");
    EXPECT_EQ(again.version, MqttVersion::v3_1_1);
    EXPECT_EQ(accept().version, MqttVersion::v5) << "another broker";
    close(MqttFailureKind::lost);
    until_attempt();
    EXPECT_EQ(fail(MqttFailureKind::version).version, MqttVersion::v3_1_1);
    fail(MqttFailureKind::refused);
    until_attempt();
    EXPECT_EQ(accept().version, MqttVersion::v5) << "the broker now refuses 3.1.1";
}

TEST_F(MqttSessionConnection, ALostAttemptAtABrokerOf5IsNotAnOldBroker) {
    start();
    accept();
    close(MqttFailureKind::lost);
    until_attempt();
    EXPECT_EQ(fail(MqttFailureKind::lost).version, MqttVersion::v5);
    EXPECT_TRUE(actions.empty());
    until_attempt();
    EXPECT_EQ(accept().version, MqttVersion::v5);
}

TEST_F(MqttSessionConnection, AVersionMayBeFixed) {
    for (const auto versions : {MqttVersions::only_5, MqttVersions::only_3_1_1}) {
        SessionRig rig;
        rig.options.versions = versions;
        rig.start();
        const auto version = versions == MqttVersions::only_5 ? MqttVersion::v5 : MqttVersion::v3_1_1;
        EXPECT_EQ(rig.fail(MqttFailureKind::version).version, version);
        rig.until_attempt();
        EXPECT_EQ(rig.accept().version, version);
    }
}

TEST_F(MqttSessionConnection, TheWillIsAdaptedToABrokerThatRefusesIt) {
    options.will = {.topic = "state", .payload = "offline", .qos = 1, .retain = true};
    start();
    EXPECT_TRUE(fail(MqttFailureKind::protocol, MqttReason::retain_not_supported).will->retain);
    const auto second = fail(MqttFailureKind::protocol, MqttReason::qos_not_supported);
    EXPECT_FALSE(second.will->retain);
    EXPECT_EQ(second.will->qos, 1);
    EXPECT_EQ(accept({.maximum_qos = 0, .retain_available = false}).will->qos, 0);
}

TEST_F(MqttSessionConnection, TheBirthIsTheFirstMessageAfterTheSubscriptions) {
    options.subscriptions = {{"cmd/#"}};
    options.birth = {.topic = "state", .payload = "online", .retain = true};
    source.count = 2;
    publish({.message = {.topic = "answer", .payload = "answer"}});
    start();
    accept();
    EXPECT_EQ(status().state, MqttState::connecting);
    const auto subscribe = expect<MqttSubscribe>();
    EXPECT_EQ(subscribe.subscriptions, options.subscriptions);
    EXPECT_TRUE(actions.empty());
    EXPECT_TRUE(connected.empty());
    event(MqttSubscribed{connection, subscribe.token, {MqttReason{1}}});
    EXPECT_EQ(connected.size(), 1U);
    EXPECT_EQ(published(), "online answer 1 2");
    close(MqttFailureKind::lost);
    advance(1s);
    accept();
    event(MqttSubscribed{connection, expect<MqttSubscribe>().token, {MqttReason{1}}});
    EXPECT_EQ(published(), "online answer 1 2");
}

TEST_F(MqttSessionConnection, ACommandBeforeTheSubscriptionIsMarked) {
    options.subscriptions = {{"cmd/#"}};
    start();
    accept();
    const auto subscribe = expect<MqttSubscribe>();
    event(MqttReceived{connection, {.topic = "cmd/early"}});
    event(MqttSubscribed{connection, subscribe.token, {MqttReason{1}}});
    event(MqttReceived{connection, {.topic = "cmd/late"}});
    const auto old = connection;
    close(MqttFailureKind::lost);
    event(MqttReceived{old, {.topic = "cmd/old"}});
    advance(1s);
    accept();
    expect<MqttSubscribe>();
    event(MqttReceived{old, {.topic = "cmd/old"}});
    event(MqttReceived{connection, {.topic = "cmd/early again"}});
    ASSERT_EQ(inbound.size(), 3U) << "those of an earlier connection are dropped";
    EXPECT_FALSE(inbound[0].subscribed);
    EXPECT_TRUE(inbound[1].subscribed);
    EXPECT_FALSE(inbound[2].subscribed);
    EXPECT_EQ(inbound[2].message.topic, "cmd/early again");
    EXPECT_EQ(inbound[2].connection, connection);
}

TEST_F(MqttSessionConnection, ARefusedSubscriptionIsReportedAndMessagesAreSent) {
    options.subscriptions = {{"cmd/a"}, {"cmd/b"}};
    source.count = 1;
    start();
    accept();
    event(MqttSubscribed{
        connection, expect<MqttSubscribe>().token, {MqttReason::success, MqttReason::not_authorized}});
    EXPECT_FALSE(status().subscribed);
    EXPECT_EQ(status().last_failure->kind, MqttFailureKind::not_authorized);
    EXPECT_EQ(published(), "1");
    acknowledge({"1"});
    EXPECT_EQ(status().failure->text, "SUBACK") << "commands are refused until the next connection";
    EXPECT_FALSE(status().refusing);
    event(MqttReceived{connection, {.topic = "cmd/a"}});
    EXPECT_FALSE(inbound.at(0).subscribed);
}

TEST_F(MqttSessionConnection, ASubscriptionWithoutAnAnswerReplacesTheConnection) {
    options.subscriptions = {{"cmd/#"}};
    start();
    accept();
    expect<MqttSubscribe>();
    advance(options.answer_timeout);
    EXPECT_FALSE(expect<MqttDisconnect>().orderly);
    close(MqttFailureKind::none);
    EXPECT_EQ(status().last_failure->kind, MqttFailureKind::timed_out);
    EXPECT_EQ(status().state, MqttState::backing_off);
}

TEST_F(MqttSessionConnection, ASessionThatIsTakenOverStopsAndTriesAgainMuchLater) {
    options.taken_over_pause = 5min;
    start();
    accept();
    close(MqttFailureKind::session_taken_over, MqttReason::session_taken_over);
    EXPECT_EQ(status().state, MqttState::stopped);
    EXPECT_EQ(status().last_failure->reason, MqttReason::session_taken_over);
    advance(5min - 1s);
    EXPECT_TRUE(actions.empty());
    EXPECT_LE(until_attempt(), 5min + 1s);
    accept();
    EXPECT_EQ(status().state, MqttState::connected);
}

TEST_F(MqttSessionConnection, AfterAMessageRateTooHighTheWindowBeginsWithOne) {
    source.count = 3;
    start();
    accept();
    EXPECT_EQ(published(), "1 2 3");
    close(MqttFailureKind::quota, MqttReason::message_rate_too_high);
    until_attempt();
    accept();
    EXPECT_EQ(published(), "1");
    acknowledge({"1"});
    EXPECT_EQ(published(), "2 3");
}

TEST_F(MqttSessionConnection, TheEndWaitsForAnswersSaysFarewellAndDisconnects) {
    options.will = {.topic = "state", .payload = "offline"};
    source.count = 2;
    start();
    accept();
    EXPECT_EQ(published(), "1 2");
    stop();
    EXPECT_EQ(status().state, MqttState::leaving);
    EXPECT_TRUE(actions.empty());
    acknowledge({"1", "2"});
    EXPECT_EQ(source.cursor, 2U);
    EXPECT_EQ(published(), "offline");
    event(MqttReceived{connection, {.topic = "cmd"}});
    EXPECT_TRUE(inbound.empty()) << "its outcome could not be published";
    acknowledge({"offline"});
    EXPECT_TRUE(expect<MqttDisconnect>().orderly);
    close(MqttFailureKind::none);
    EXPECT_EQ(status().state, MqttState::off);
    EXPECT_EQ(session().next_wakeup(), kNever);
    EXPECT_EQ(status().counters.lost_connections, 0U);
    start();
    EXPECT_EQ(accept().client_id, "takt") << "it may start again";
}

TEST_F(MqttSessionConnection, TheEndDoesNotWaitForEver) {
    options.leave_timeout = 2s;
    source.count = 1;
    start();
    accept();
    EXPECT_EQ(published(), "1");
    stop();
    advance(2s);
    expect<MqttDisconnect>();
    close(MqttFailureKind::lost);
    EXPECT_EQ(status().state, MqttState::off);
    EXPECT_EQ(source.rewinds, 1U);
}

TEST_F(MqttSessionConnection, TheEndInAnyStateIsOff) {
    stop();
    EXPECT_EQ(status().state, MqttState::off);
    session().start(now);
    stop();
    connection = expect<MqttConnect>().connection;
    expect<MqttDisconnect>();
    close(MqttFailureKind::none);
    EXPECT_EQ(status().state, MqttState::off);
    start();
    fail(MqttFailureKind::refused);
    stop();
    EXPECT_EQ(status().state, MqttState::off) << "while it waits for the next attempt";
    EXPECT_EQ(session().next_wakeup(), kNever);
}

}  // namespace mqtt_session_connection_test
}  // namespace takt::publish
