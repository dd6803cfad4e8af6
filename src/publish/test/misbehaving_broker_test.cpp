// Sessions on the real pipe with another broker (aedes) that drops, delays, doubles and reorders PUBACKs, and
// cuts connections after any byte.
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <filesystem>
#include <set>
#include <sstream>
#include <string>

#include "broker_process.hpp"
#include "live_session.hpp"

namespace takt::publish {
namespace misbehaving_broker_test {

const std::string kPeers = TAKT_NODE_PEERS;

class MisbehavingBroker {
public:
    MisbehavingBroker() : port_(free_port()) {
        int ends[2];
        socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends);
        control_ = ends[0];
        process_.emplace_back(
            std::vector<std::string>{"node", kPeers + "/misbehaving_broker.mjs", std::to_string(port_)},
            folder_ / "output", ends[1]);
        close(ends[1]);
        EXPECT_TRUE(appears("ready\n")) << output();
    }
    ~MisbehavingBroker() { close(control_); }

    void command(const std::string& line) {
        skip();
        send(control_, (line + "\n").data(), line.size() + 1, MSG_NOSIGNAL);
        EXPECT_TRUE(appears("set " + line + "\n")) << output();
    }
    /// Later output only counts.
    void skip() { begin_ = folder_.read("output").size(); }
    [[nodiscard]] std::string output() const { return folder_.read("output").substr(begin_); }
    bool appears(const std::string& text) const {
        for (int i = 0; i < 1000; ++i) {
            if (output().find(text) != std::string::npos) return true;
            std::this_thread::sleep_for(5ms);
        }
        return false;
    }
    /// The broker accepted messages 1 to `count`; the first of each in order.
    [[nodiscard]] testing::AssertionResult accepted_in_order(std::uint64_t count) const {
        std::set<std::uint64_t> seen;
        std::istringstream lines(output());
        for (std::string word; lines >> word;) {
            std::uint64_t number = 0;
            if (word != "message" || !(lines >> number) || seen.contains(number)) continue;
            if (number != seen.size() + 1) return testing::AssertionFailure() << number << " is too early";
            seen.insert(number);
        }
        if (seen.size() != count) return testing::AssertionFailure() << seen.size() << " arrived";
        return testing::AssertionSuccess();
    }
    [[nodiscard]] std::uint16_t port() const { return port_; }

private:
    takt::test::Folder folder_;
    std::uint16_t port_;
    int control_ = -1;
    std::size_t begin_ = 0;
    std::vector<Process> process_;
};

struct MqttMisbehavingBroker : testing::Test {
    void SetUp() override {
        if (!std::filesystem::exists(kPeers + "/node_modules/aedes"))
            GTEST_SKIP() << "the peers from npm are not installed (tests/peers/node)";
        broker.emplace();
    }
    /// A session that is quick to connect again.
    LiveSession& session() {
        live.emplace(broker->port());
        live->options.first_pause = 1ms;
        live->options.longest_pause = 20ms;
        live->options.answer_timeout = 300ms;
        return *live;
    }

    std::optional<MisbehavingBroker> broker;
    std::optional<LiveSession> live;
};

TEST_F(MqttMisbehavingBroker, OnlySpeaks3_1_1AndIsFoundOut) {
    session().source.count = 100;
    broker->skip();
    live->start();
    EXPECT_TRUE(live->delivers_all());
    EXPECT_EQ(live->status().version, MqttVersion::v3_1_1);
    EXPECT_TRUE(broker->accepted_in_order(100));
}

TEST_F(MqttMisbehavingBroker, DroppedAcknowledgementsReplaceTheConnection) {
    broker->command("drop 40");
    session().source.count = 100;
    live->options.window = 8;
    live->start();
    EXPECT_TRUE(live->delivers_all(20s));
    EXPECT_TRUE(broker->accepted_in_order(100));
    EXPECT_GE(live->status().counters.repeated, 2U);
    EXPECT_EQ(live->status().last_failure->kind, MqttFailureKind::timed_out);
}

TEST_F(MqttMisbehavingBroker, DoubledLateAndReorderedAcknowledgementsAreHarmless) {
    for (const char* command : {"duplicate 3", "delay 20", "reverse 4"}) {
        broker->command(command);
        session().source.count = 200;
        live->options.window = 8;
        live->start();
        EXPECT_TRUE(live->delivers_all()) << command;
        EXPECT_TRUE(broker->accepted_in_order(200)) << command;
        EXPECT_EQ(live->status().counters.acknowledged, 200U) << command;
        EXPECT_EQ(live->status().counters.repeated, 0U) << command;
        live->kill();
    }
}

TEST_F(MqttMisbehavingBroker, AConnectionCutAfterAnyByteLosesNothing) {
    std::size_t bytes = 1;
    for (bool was_cut = true; was_cut; ++bytes) {
        ASSERT_LT(bytes, 2000U);
        broker->command("cut " + std::to_string(bytes));
        LiveSession& its = session();
        its.options.versions = MqttVersions::only_3_1_1;
        its.options.client_id = "takt";
        its.options.subscriptions = {{"cmd/#"}};
        its.options.birth = {.topic = "state", .payload = "online", .retain = true};
        its.options.will = {.topic = "state", .payload = "offline", .retain = true};
        its.source.count = 5;
        its.start();
        ASSERT_TRUE(its.delivers_all()) << "cut after " << bytes;
        ASSERT_TRUE(broker->accepted_in_order(5)) << "cut after " << bytes;
        was_cut = broker->output().find("cut\n") != std::string::npos;
        its.kill();
    }
    EXPECT_GT(bytes, 150U);
    RecordProperty("bytes", static_cast<int>(bytes));
}

}  // namespace misbehaving_broker_test
}  // namespace takt::publish
