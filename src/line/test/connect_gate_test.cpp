// Connections that are all to be made at once, on real sockets.
#include "takt/line/connect_gate.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <set>

#include "network/backoff.hpp"
#include "support.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/tcp_server.hpp"

namespace takt::line {
namespace connect_gate_test {

TEST(ConnectGate, LetsInTheFirstOnesFirstAndNoMoreThanItsLimit) {
    const auto loop = make_loop();
    ConnectGate gate(*loop, {.most = 2, .undecided_limit = 1h, .burst = 100});
    std::vector<int> let_in;
    std::vector<ConnectGate::Pass> passes;
    for (int i = 0; i < 5; ++i) passes.push_back(gate.ask([&let_in, i] { let_in.push_back(i); }));
    EXPECT_TRUE(let_in.empty()) << "never from within ask()";
    EXPECT_TRUE(loop->run_until([&] { return let_in.size() == 2; }, kDeadline));
    EXPECT_EQ(gate.under_way(), 2U);
    EXPECT_EQ(gate.waiting(), 3U);
    passes[2] = {};  // one that waits gives up
    passes[0] = {};  // one that was let in has ended
    EXPECT_TRUE(loop->run_until([&] { return let_in.size() == 3; }, kDeadline));
    EXPECT_EQ(let_in, (std::vector{0, 1, 3}));
    EXPECT_EQ(gate.under_way(), 2U);
    passes.clear();
    EXPECT_EQ(gate.under_way() + gate.waiting(), 0U);
}

TEST(ConnectGate, OneThatHangsGivesItsPlaceUp) {
    const auto loop = make_loop();
    ConnectGate gate(*loop, {.most = 1, .undecided_limit = 1ms, .burst = 100});
    int let_in = 0;
    const auto hanging = gate.ask([&] { ++let_in; });
    const auto next = gate.ask([&] { ++let_in; });
    EXPECT_TRUE(loop->run_until([&] { return let_in == 2; }, kDeadline));
    EXPECT_EQ(gate.under_way(), 1U);
}

TEST(ConnectGate, KeepsItsRate) {
    const auto loop = make_loop();
    ConnectGate gate(*loop, {.most = 100, .burst = 3, .interval = 10ms});
    std::vector<Instant> let_in;
    std::vector<ConnectGate::Pass> passes;
    const Instant begin = now();
    for (int i = 0; i < 6; ++i) passes.push_back(gate.ask([&] { let_in.push_back(now()); }));
    EXPECT_TRUE(loop->run_until([&] { return let_in.size() == 6; }, kDeadline));
    for (std::size_t i = 3; i < 6; ++i)
        EXPECT_GE(let_in[i] - begin, static_cast<Duration::rep>(i - 2) * Duration(10ms)) << i;
}

TEST(Backoff, LinesOfOtherNamesComeBackAtOtherTimes) {
    std::set<Duration> pauses;
    for (int i = 0; i < 100; ++i) {
        Backoff backoff("10.0.0." + std::to_string(i) + ":502");
        Duration most = Backoff::kFirst;
        for (int attempt = 0; attempt < 8; ++attempt) {
            const Duration pause = backoff.next();
            EXPECT_LE(pause, most);
            EXPECT_GE(pause, most * 3 / 4);
            pauses.insert(pause);
            most = std::min(2 * most, Backoff::kLongest);
        }
        backoff.reset();
        EXPECT_LE(backoff.next(), Backoff::kFirst);
    }
    EXPECT_GT(pauses.size(), 600U);
    EXPECT_EQ(Backoff("a").next(), Backoff("a").next()) << "the same each time";
}

class Quiet final : public Session {
public:
    Engine& engine() override { return engine_; }
    [[nodiscard]] Instant last_received() const override { return now(); }
    bool finished() const override { return false; }

private:
    ScriptEngine engine_;
};

/// Listens, but its queue is full: a connecting client gets no answer, as behind a firewall that drops.
struct Swallowing {
    Swallowing() : fd(::socket(AF_INET, SOCK_STREAM, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(::bind(fd.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
        EXPECT_EQ(::listen(fd.get(), 0), 0);
        socklen_t length = sizeof address;
        EXPECT_EQ(::getsockname(fd.get(), reinterpret_cast<sockaddr*>(&address), &length), 0);
        port = ntohs(address.sin_port);
        for (auto& filler : fillers) {
            filler.reset(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0));
            ::connect(filler.get(), reinterpret_cast<sockaddr*>(&address), sizeof address);
        }
    }
    os::Descriptor fd;
    std::uint16_t port = 0;
    std::array<os::Descriptor, 4> fillers;
};

// Hostile input 56: hosts that swallow attempts, and one that refuses, before a crowd that answers.
TEST(ConnectGate, HostsThatHangOrRefuseDelayNoOther) {
    const auto loop = make_loop();
    ConnectGate gate(*loop, {.most = 4, .undecided_limit = 5ms});
    const Swallowing swallowing;
    const auto make = [](Instant, const Peer&) { return std::make_unique<Quiet>(); };
    const auto server = std::move(TcpServer::listen(*loop, {"127.0.0.1", 0}, make, {})).value();
    std::uint16_t refusing = 0;
    {
        const auto gone = std::move(TcpServer::listen(*loop, {"127.0.0.1", 0}, make, {})).value();
        refusing = gone->port();
    }
    DriverOptions options;
    options.gate = &gate;
    options.connect_limit = 1h;
    std::vector<std::unique_ptr<ScriptEngine>> engines;
    std::vector<std::unique_ptr<Driver>> drivers;
    const auto connect = [&](std::uint16_t port) {
        engines.push_back(std::make_unique<ScriptEngine>());
        drivers.push_back(connect_tcp(*loop, "127.0.0.1", port, *engines.back(), options));
    };
    for (int i = 0; i < 8; ++i) connect(swallowing.port);
    for (int i = 0; i < 4; ++i) connect(refusing);
    for (int i = 0; i < 50; ++i) connect(server->port());
    std::size_t most = 0;
    const bool all_up = loop->run_until(
        [&] {
            most = std::max(most, gate.under_way());
            return std::all_of(drivers.begin() + 12, drivers.end(), [](const auto& d) { return d->up(); });
        },
        kDeadline);
    EXPECT_TRUE(all_up);
    EXPECT_LE(most, 4U);
    for (int i = 0; i < 12; ++i) EXPECT_FALSE(drivers[static_cast<std::size_t>(i)]->up()) << i;
    EXPECT_GE(drivers[8]->counters().failed_attempts, 1U);
    EXPECT_EQ(drivers[0]->counters().failed_attempts, 0U) << "it still waits";
}

}  // namespace connect_gate_test
}  // namespace takt::line
