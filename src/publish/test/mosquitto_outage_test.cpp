// Brokers that go away, and come back, or hang.
#include <gtest/gtest.h>

#include <cstdint>
#include <set>
#include <sstream>
#include <string>

#include "broker_process.hpp"
#include "live_session.hpp"

namespace takt::publish {
namespace mosquitto_outage_test {

// The subscriber's first sight of each number must be in order; a repeated one may come at any time.
void expect_all_in_order(const std::string& output, std::uint64_t count) {
    std::istringstream received(output);
    std::set<std::uint64_t> seen;
    for (std::uint64_t number = 0; received >> number;) {
        if (seen.contains(number)) continue;
        ASSERT_EQ(number, seen.size() + 1) << "a message is missing or too early";
        seen.insert(number);
    }
    EXPECT_EQ(seen.size(), count);
}

TEST(MosquittoOutage, EveryMessageArrivesInOrderAlthoughTheBrokerRestarts) {
    constexpr std::uint64_t kMessages = 20'000;
    takt::test::Folder storage;
    const std::string settings =
        "allow_anonymous true\npersistence true\nmax_queued_messages 0\npersistence_location " +
        storage.path() + "/\n";
    TestBroker broker(settings);
    auto subscriber = broker.client("mosquitto_sub", {"-c", "-i", "reader", "-q", "1", "-t", "data"}, "sub");
    LiveSession live(broker.port());
    live.start();
    ASSERT_TRUE(live.connects());
    live.run([] { return false; }, 300ms);
    live.source.count = kMessages;
    for (const std::uint64_t part : {kMessages / 4, kMessages / 2}) {
        ASSERT_TRUE(live.run([&] { return live.source.cursor >= part; }, 30s));
        broker.end(SIGTERM);
        ASSERT_TRUE(live.run([&] { return live.status().state != MqttState::connected; }));
        broker.start();
    }
    ASSERT_TRUE(live.delivers_all(60s));
    const std::string last = "\n" + std::to_string(kMessages) + "\n";
    EXPECT_TRUE(live.run([&] { return broker.folder().read("sub").ends_with(last); }, 20s));
    expect_all_in_order(broker.folder().read("sub"), kMessages);
    EXPECT_EQ(live.status().counters.lost_connections, 2U);
    EXPECT_EQ(live.status().counters.acknowledged, kMessages);
}

TEST(MosquittoOutage, AKilledBrokerIsFoundAgain) {
    TestBroker broker;
    LiveSession live(broker.port());
    live.source.count = 20'000;
    live.start();
    ASSERT_TRUE(live.run([&] { return live.source.cursor >= 5'000; }, 30s));
    broker.end(SIGKILL);
    ASSERT_TRUE(live.fails_with(MqttFailureKind::lost));
    broker.start();
    EXPECT_TRUE(live.delivers_all(30s));
    EXPECT_EQ(live.status().counters.acknowledged, 20'000U);
    EXPECT_EQ(live.status().counters.connects, 2U);
}

TEST(MosquittoOutage, ABrokerThatHangsWithMessagesInFlightIsLeft) {
    TestBroker broker;
    LiveSession live(broker.port());
    live.options.answer_timeout = 500ms;
    live.options.connect_timeout = 500ms;
    live.start();
    ASSERT_TRUE(live.connects());
    broker.send(SIGSTOP);
    live.source.count = 100;
    EXPECT_TRUE(live.fails_with(MqttFailureKind::timed_out));
    broker.send(SIGCONT);
    EXPECT_TRUE(live.delivers_all());
    EXPECT_EQ(live.status().counters.acknowledged, 100U);
    EXPECT_GE(live.status().counters.repeated, 1U);
}

TEST(MosquittoOutage, AnIdleBrokerThatHangsLongerThanTheKeepAliveIsLeft) {
    TestBroker broker;
    LiveSession live(broker.port());
    live.options.keep_alive = 5s;  // the least of libmosquitto
    live.start();
    ASSERT_TRUE(live.connects());
    broker.send(SIGSTOP);
    EXPECT_TRUE(live.run([&] { return live.status().last_failure.has_value(); }, 14s));
    EXPECT_EQ(name(live.status().last_failure->kind), "timed_out");
    broker.send(SIGCONT);
    EXPECT_TRUE(live.connects(20s));
}

}  // namespace mosquitto_outage_test
}  // namespace takt::publish
