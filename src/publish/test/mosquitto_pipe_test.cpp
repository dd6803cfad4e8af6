// Sessions on the real pipe, with a real mosquitto.
#include "mqtt/mosquitto_pipe.hpp"

#include <gtest/gtest.h>

#include <set>
#include <sstream>
#include <string>

#include "broker_process.hpp"
#include "live_session.hpp"
#include "scripted_broker.hpp"

// libmosquitto 2.0.11 unlocks a mutex that it did not lock when it receives DISCONNECT
// (do_client_disconnect).
extern "C" const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
    return "mutex:libmosquitto.so\n";
}

namespace takt::publish {
namespace mosquitto_pipe_test {

constexpr MqttVersions kBothVersions[] = {MqttVersions::only_5, MqttVersions::only_3_1_1};

TEST(MosquittoPipe, PublishesWithBothVersions) {
    TestBroker broker;
    for (const auto version : kBothVersions) {
        auto subscriber =
            broker.client("mosquitto_sub", {"-t", "#", "-C", "500", "-q", "1", "-W", "10"}, "sub");
        LiveSession live(broker.port());
        live.options.versions = version;
        live.start();
        ASSERT_TRUE(live.connects());
        EXPECT_EQ(live.status().version,
                  version == MqttVersions::only_5 ? MqttVersion::v5 : MqttVersion::v3_1_1);
        live.run([] { return false; }, 300ms);  // the subscriber connects meanwhile
        live.source.count = 500;
        EXPECT_TRUE(live.delivers_all());
        EXPECT_EQ(live.status().counters.acknowledged, 500U);
        EXPECT_EQ(subscriber.wait(), 0) << "the subscriber did not get 500 messages";
        live.stop();
    }
    std::istringstream received(broker.folder().read("sub"));
    for (int version = 0; version < 2; ++version)
        for (int number = 1, got = 0; number <= 500; ++number) {
            received >> got;
            ASSERT_EQ(got, number);
        }
}

TEST(MosquittoPipe, HandsOverQos0) {
    TestBroker broker;
    LiveSession live(broker.port());
    live.source.adapt = [](MqttMessage& message, std::uint64_t) { message.qos = 0; };
    live.source.count = 1000;
    live.start();
    EXPECT_TRUE(live.delivers_all());
    EXPECT_EQ(live.status().counters.unproved, 1000U);
}

TEST(MosquittoPipe, TheBrokersLimitsReachTheSession) {
    TestBroker broker(
        "allow_anonymous true\nmax_packet_size 2000\nmax_inflight_messages 1\nmax_keepalive 60\n");
    LiveSession live(broker.port());
    live.options.keep_alive = 600s;
    live.source.adapt = [](MqttMessage& message, std::uint64_t number) {
        if (number == 2) message.payload = std::string(3000, 'x');
    };
    live.source.count = 50;
    live.start();
    EXPECT_TRUE(live.delivers_all());
    EXPECT_EQ(live.source.limits.packet, 2000U);
    EXPECT_EQ(live.status().window, 1U);
    EXPECT_EQ(live.status().keep_alive, 60s);
    EXPECT_EQ(live.source.rejected, (std::map<std::uint64_t, MqttReason>{{2, MqttReason::packet_too_large}}));
    EXPECT_EQ(live.status().counters.lost_connections, 0U);
}

TEST(MosquittoPipe, TheWillFollowsAKillAndTheBirthIsRetained) {
    TestBroker broker;
    for (const auto version : kBothVersions) {
        LiveSession live(broker.port());
        live.options.versions = version;
        live.options.birth = {.topic = "state", .payload = "online", .retain = true};
        live.options.will = {.topic = "state", .payload = "offline", .retain = true};
        live.start();
        ASSERT_TRUE(live.run([&] { return live.status().counters.live_published == 1; }));
        broker.client("mosquitto_sub", {"-t", "state", "-C", "1", "-W", "5"}, "states").wait();
        auto subscriber = broker.client("mosquitto_sub", {"-t", "state", "-C", "2", "-W", "5"}, "states");
        live.run([] { return false; }, 300ms);
        live.kill();
        EXPECT_EQ(subscriber.wait(), 0);
    }
    EXPECT_EQ(broker.folder().read("states"), "online\nonline\noffline\nonline\nonline\noffline\n");
}

TEST(MosquittoPipe, AnOrderlyEndSaysOffline) {
    TestBroker broker;
    LiveSession live(broker.port());
    live.options.will = {.topic = "state", .payload = "offline", .retain = true};
    live.start();
    ASSERT_TRUE(live.connects());
    live.stop();
    broker.client("mosquitto_sub", {"-t", "state", "-C", "1", "-W", "5"}, "states").wait();
    EXPECT_EQ(broker.folder().read("states"), "offline\n");
}

TEST(MosquittoPipe, ReceivesCommandsWithTheirProperties) {
    TestBroker broker;
    LiveSession live(broker.port());
    live.options.subscriptions = {{"cmd/a"}, {"cmd/b/#", 0}};
    broker.client("mosquitto_pub", {"-t", "cmd/a", "-m", "old", "-r"}, "pub").wait();
    live.start();
    ASSERT_TRUE(live.connects());
    EXPECT_TRUE(live.status().subscribed);
    ASSERT_TRUE(live.run([&] { return live.inbound.size() == 1; }));
    EXPECT_TRUE(live.inbound[0].message.retain);
    broker
        .client("mosquitto_pub",
                {"-V",
                 "mqttv5",
                 "-q",
                 "1",
                 "-t",
                 "cmd/b/x",
                 "-m",
                 "set",
                 "-D",
                 "publish",
                 "response-topic",
                 "answer",
                 "-D",
                 "publish",
                 "correlation-data",
                 "id7",
                 "-D",
                 "publish",
                 "message-expiry-interval",
                 "20",
                 "-D",
                 "publish",
                 "user-property",
                 "key",
                 "value",
                 "-D",
                 "publish",
                 "content-type",
                 "text"},
                "pub")
        .wait();
    ASSERT_TRUE(live.run([&] { return live.inbound.size() == 2; })) << broker.folder().read("pub");
    const auto& message = live.inbound[1].message;
    EXPECT_TRUE(live.inbound[1].subscribed);
    EXPECT_EQ(message.topic, "cmd/b/x");
    EXPECT_EQ(message.payload, "set");
    EXPECT_FALSE(message.retain);
    EXPECT_EQ(message.properties.response_topic, "answer");
    EXPECT_EQ(message.properties.correlation_data, "id7");
    EXPECT_EQ(message.properties.expiry_s, 20U);
    EXPECT_EQ(message.properties.content_type, "text");
    ASSERT_EQ(message.properties.user.size(), 1U);
    EXPECT_EQ(message.properties.user[0], (MqttUserProperty{"key", "value"}));
}

TEST(MosquittoPipe, APropertyReachesASubscriber) {
    TestBroker broker;
    auto subscriber =
        broker.client("mosquitto_sub",
                      {"-V", "mqttv5", "-t", "#", "-C", "1", "-W", "10", "-F", "%R %D %E %C %P %p"}, "sub");
    LiveSession live(broker.port());
    live.start();
    ASSERT_TRUE(live.connects());
    live.run([] { return false; }, 300ms);
    LiveMessage answer{.message = {.topic = "answer", .payload = "done"}};
    answer.message.properties = {.response_topic = "r",
                                 .correlation_data = "id8",
                                 .expiry_s = 60,
                                 .content_type = "text",
                                 .user = {{"repeated", "1"}}};
    EXPECT_TRUE(live.session().publish(LiveSession::now(), std::move(answer)));
    EXPECT_TRUE(live.run([&] { return live.status().counters.live_published == 1; }));
    EXPECT_EQ(subscriber.wait(), 0);
    EXPECT_EQ(broker.folder().read("sub"), "r id8 60 text repeated:1 done\n");
}

TEST(MosquittoPipe, SaysWhyThereIsNoConnection) {
    LiveSession refused(free_port());
    refused.start();
    EXPECT_TRUE(refused.fails_with(MqttFailureKind::refused));
    LiveSession unknown(1883);
    unknown.options.brokers[0].host = "no-such-host.invalid";
    unknown.start();
    EXPECT_TRUE(unknown.fails_with(MqttFailureKind::dns));
}

TEST(MosquittoPipe, ABrokerOfThisComputerIsNearby) {
    for (const auto* host : {"127.0.0.1", "localhost"}) {
        LiveSession refused(free_port());
        refused.options.brokers[0].host = host;
        refused.options.first_pause = 1h;
        refused.options.longest_nearby_pause = 20ms;
        refused.start();
        EXPECT_TRUE(refused.run([&] { return refused.status().counters.attempts > 2; }, 2s)) << host;
    }
}

TEST(MosquittoPipe, TheNextBrokerIsTriedWhenTheFirstIsDown) {
    TestBroker broker;
    LiveSession live(broker.port());
    live.options.brokers.insert(live.options.brokers.begin(), {.host = "127.0.0.1", .port = free_port()});
    live.start();
    EXPECT_TRUE(live.connects());
    EXPECT_EQ(live.status().broker, 1U);
}

TEST(MosquittoPipe, AHostNameMayHaveAnAddressWithoutAListener) {
    TestBroker broker;  // IPv4 only; localhost may also be ::1
    LiveSession live(broker.port());
    live.options.brokers[0].host = "localhost";
    live.start();
    EXPECT_TRUE(live.connects());
}

TEST(MosquittoPipe, AWrongPasswordIsNotAuthorized) {
    TestBroker broker("allow_anonymous true\n");
    broker.folder().write("passwords", "takt:secret\n");
    ASSERT_EQ(std::system(("mosquitto_passwd -U " + broker.folder() / "passwords").c_str()), 0);
    broker.configure("allow_anonymous false\npassword_file " + broker.folder() / "passwords" + "\n");
    broker.end(SIGTERM);
    broker.start();
    for (const auto version : kBothVersions)
        for (const char* password : {"", "wrong", "secret"}) {
            LiveSession live(broker.port());
            live.options.versions = version;
            live.options.user = "takt";
            live.options.password = password;
            live.start();
            if (password == std::string("secret")) {
                EXPECT_TRUE(live.connects());
            } else {
                EXPECT_TRUE(live.fails_with(MqttFailureKind::not_authorized)) << password;
                EXPECT_EQ(live.status().state, MqttState::backing_off);
            }
        }
}

TEST(MosquittoPipe, ATopicThatTheBrokerForbidsIsRefusedNotLost) {
    TestBroker broker("allow_anonymous true\n");
    broker.folder().write("acl", "topic readwrite data\n");
    broker.configure("allow_anonymous true\nacl_file " + broker.folder() / "acl" + "\n");
    broker.end(SIGTERM);
    broker.start();
    LiveSession live(broker.port());
    live.source.adapt = [](MqttMessage& message, std::uint64_t number) {
        if (number == 3) message.topic = "forbidden";
    };
    live.source.count = 5;
    live.start();
    EXPECT_TRUE(live.fails_with(MqttFailureKind::not_authorized));
    EXPECT_FALSE(live.delivers_all(1s));
    EXPECT_EQ(live.source.cursor, 2U);
    EXPECT_EQ(live.status().state, MqttState::connected);
    live.source.adapt = [](MqttMessage&, std::uint64_t) {};
    EXPECT_TRUE(live.delivers_all()) << "the user corrected the topic";
}

TEST(MosquittoPipe, AConnectionThatAnotherClientTakesOverIsNotFoughtFor) {
    TestBroker broker;  // mosquitto 2.0.11 closes the old connection without a reason
    LiveSession live(broker.port());
    live.options.first_pause = 2s;
    live.options.longest_pause = 2s;
    live.start();
    ASSERT_TRUE(live.connects());
    auto other = broker.client("mosquitto_sub", {"-i", live.options.client_id, "-t", "#"}, "sub");
    EXPECT_TRUE(live.fails_with(MqttFailureKind::lost));
    EXPECT_FALSE(live.connects(900ms));
}

TEST(MosquittoPipe, SessionTakenOverStopsTheSession) {
    ScriptedBroker broker({kAccepted + std::string("\xE0\x01\x8E", 3)});
    LiveSession live(broker.port());
    live.start();
    EXPECT_TRUE(live.fails_with(MqttFailureKind::session_taken_over));
    EXPECT_EQ(live.status().state, MqttState::stopped);
    EXPECT_FALSE(live.connects(500ms));
    EXPECT_EQ(broker.connections(), 1U);
}

TEST(MosquittoPipe, ABrokerOf3_1_1IsFoundOut) {
    const struct {
        std::string to_5;
        const char* what;
    } rows[] = {
        {std::string("\x20\x02\x00\x01", 4), "the return code of 3.1.1"},
        {std::string("\x20\x03\x00\x84\x00", 5), "the reason of 5"},
        {"", "closes the connection"},
    };
    for (const auto& row : rows) {
        ScriptedBroker broker({row.to_5, std::string("\x20\x02\x00\x00", 4) + kStaysOpen});
        LiveSession live(broker.port());
        live.start();
        EXPECT_TRUE(live.connects()) << row.what;
        EXPECT_EQ(live.status().version, MqttVersion::v3_1_1);
        EXPECT_EQ(broker.connections(), 2U);
    }
}

TEST(MosquittoPipe, ReasonsOfConnackReachTheUser) {
    const struct {
        int reason;
        MqttFailureKind kind;
    } rows[] = {{0x86, MqttFailureKind::not_authorized}, {0x87, MqttFailureKind::not_authorized},
                {0x88, MqttFailureKind::unavailable},    {0x8A, MqttFailureKind::not_authorized},
                {0x97, MqttFailureKind::quota},          {0x9F, MqttFailureKind::quota}};
    for (const auto& row : rows) {
        const std::string connack{0x20, 0x03, 0x00, static_cast<char>(row.reason), 0x00};
        ScriptedBroker broker({connack});
        LiveSession live(broker.port());
        live.options.versions = MqttVersions::only_5;
        live.start();
        EXPECT_TRUE(live.fails_with(row.kind)) << row.reason;
        EXPECT_EQ(live.status().last_failure->reason, static_cast<MqttReason>(row.reason));
    }
}

TEST(MosquittoPipe, GarbageEndsTheConnection) {
    for (const auto& bytes :
         {std::string("HTTP/1.1 400 Bad Request\r\n\r\n"), std::string(64, '\xFF'),
          std::string("\x20\x03\x00\x00", 4), kAccepted + std::string("\x40\x01\x00", 3)}) {
        ScriptedBroker broker({bytes, bytes});
        LiveSession live(broker.port());
        live.options.connect_timeout = 500ms;
        live.start();
        EXPECT_TRUE(live.run([&] { return live.status().last_failure.has_value(); }));
    }
}

TEST(MosquittoPipe, EndsAtOnceWhileABrokerDoesNotAnswer) {
    ScriptedBroker broker({kStaysOpen, kStaysOpen});
    LiveSession live(broker.port());
    live.options.versions = MqttVersions::only_5;
    live.options.connect_timeout = 4s;
    live.start();
    EXPECT_TRUE(live.fails_with(MqttFailureKind::timed_out));
    live.run([] { return false; }, 150ms);
    const Instant begin = LiveSession::now();
    live.kill();
    EXPECT_LT(LiveSession::now() - begin, live.options.connect_timeout - 1s);
}

}  // namespace mosquitto_pipe_test
}  // namespace takt::publish
