#include "takt/web/web_server.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "takt/line/socket.hpp"

namespace takt::web {
namespace web_server_test {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

/// A blocking client.
class Client {
public:
    explicit Client(std::uint16_t port, const char* from = "127.0.0.1") {
        const auto address = line::resolve("127.0.0.1", port, true).value().front();
        const auto source = line::resolve(from, 0, true).value().front();
        fd_.reset(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
        EXPECT_EQ(::bind(fd_.get(), source.get(), source.length), 0);
        EXPECT_EQ(::connect(fd_.get(), address.get(), address.length), 0);
        const timeval limit{10, 0};
        ::setsockopt(fd_.get(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    }
    void send(const std::string& text) const {
        EXPECT_EQ(::send(fd_.get(), text.data(), text.size(), MSG_NOSIGNAL),
                  static_cast<ssize_t>(text.size()));
    }
    /// The next bytes; empty at the end.
    std::string receive() const {
        char buffer[65536];
        const auto count = ::recv(fd_.get(), buffer, sizeof buffer, 0);
        return {buffer, static_cast<std::size_t>(std::max<ssize_t>(count, 0))};
    }
    [[nodiscard]] std::string receive_available() const {
        char buffer[4096];
        const auto count = ::recv(fd_.get(), buffer, sizeof buffer, MSG_DONTWAIT);
        return {buffer, static_cast<std::size_t>(std::max<ssize_t>(count, 0))};
    }
    std::string receive_until(const std::string& part) const {
        std::string all;
        for (auto more = receive(); !more.empty(); more = receive()) {
            all += more;
            if (all.find(part) != std::string::npos) break;
        }
        return all;
    }
    std::string get(const std::string& path) const {
        send("GET /api/v1" + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n");
        return receive_until("}\n");
    }

private:
    os::Descriptor fd_;
};

class Endless final : public StreamSource {
public:
    bool take(std::string& out) override {
        out += "data: " + std::string(10'000, 'x') + "\n\n";
        return true;
    }
};

struct WebServerTest : ::testing::Test {
    std::unique_ptr<WebServer> start(WebServerOptions options = {}) {
        options.address.port = 0;
        return WebServer::start(
                   options,
                   {{Method::get, "/quick", false,
                     [](const ApiRequest&) { return ApiResponse::json(file::Json::object()); }},
                    {Method::get, "/slow", false,
                     [this](const ApiRequest&) {
                         ++slow;
                         while (hold) std::this_thread::sleep_for(1ms);
                         return ApiResponse::json(file::Json::object());
                     }},
                    {Method::get, "/patient", false,
                     [this](const ApiRequest& request) {
                         ++patient;
                         while (!request.stop.stop_requested()) std::this_thread::sleep_for(1ms);
                         ++ended;
                         return ApiResponse::json(file::Json::object(), 409);
                     },
                     Work::planning, true},
                    {Method::get, "/huge", false,
                     [](const ApiRequest&) { return ApiResponse{.body = std::string(20 << 20, 'x')}; }}},
                   {{"/endless",
                     [](const ApiRequest&) -> std::unique_ptr<StreamSource> {
                         return std::make_unique<Endless>();
                     }}})
            .value();
    }
    /// Sooner than an idle connection is closed by itself.
    static bool is_served_soon(const WebServer& server) {
        for (const auto end = Clock::now() + 10s; Clock::now() < end;) {
            if (Client(server.port()).get("/quick").starts_with("HTTP/1.1 200 ")) return true;
            std::this_thread::sleep_for(20ms);
        }
        return false;
    }
    static bool comes(const std::function<bool()>& condition) {
        for (const auto end = Clock::now() + 10s; Clock::now() < end && !condition();)
            std::this_thread::sleep_for(1ms);
        return condition();
    }
    std::atomic<int> patient = 0;
    std::atomic<int> ended = 0;
    std::atomic<bool> hold = true;
    std::atomic<int> slow = 0;
};

TEST_F(WebServerTest, ServesManyRequestsOnAConnection) {
    const auto server = start();
    const Client client(server->port());
    for (int i = 0; i < 20; ++i) EXPECT_TRUE(client.get("/quick").starts_with("HTTP/1.1 200 OK\r\n"));
    EXPECT_EQ(server->url(), "http://127.0.0.1:" + std::to_string(server->port()) + "/");
}

TEST_F(WebServerTest, StopsAtOnceWithStalledReaders) {
    const auto server = start();
    const Client stream(server->port());
    stream.send("GET /api/v1/endless HTTP/1.1\r\nHost: localhost\r\n\r\n");
    stream.receive_until("data: ");
    const Client huge(server->port());
    huge.send("GET /api/v1/huge HTTP/1.1\r\nHost: localhost\r\n\r\n");
    huge.receive();
    const Client half(server->port());
    half.send("GET /");
    const auto begin = Clock::now();
    server->stop();
    EXPECT_LT(Clock::now() - begin, 5s);
    server->poke();
}

TEST_F(WebServerTest, ServesOthersWhileReadersStall) {
    const auto server = start();
    std::vector<std::unique_ptr<Client>> stalled;
    for (int i = 0; i < 12; ++i) {
        stalled.push_back(std::make_unique<Client>(server->port()));
        stalled.back()->send(i % 2 == 0 ? "GET /api/v1/endless HTTP/1.1\r\nHost: localhost\r\n\r\n"
                                        : "GET /api/v1/hu");
    }
    const Client client(server->port());
    for (int i = 0; i < 50; ++i) EXPECT_TRUE(client.get("/quick").starts_with("HTTP/1.1 200 OK\r\n"));
}

TEST_F(WebServerTest, AnswersWith503WhenAllThreadsWork) {
    const auto server = start({.threads = 1, .waiting = 1});
    std::vector<std::unique_ptr<Client>> clients;
    const auto ask = [&] {
        clients.push_back(std::make_unique<Client>(server->port()));
        clients.back()->send("GET /api/v1/slow HTTP/1.1\r\nHost: localhost\r\n\r\n");
    };
    ask();
    while (slow == 0) std::this_thread::sleep_for(1ms);
    ask();
    ask();
    ask();
    std::string refused;
    for (std::size_t i = 3; i >= 1 && refused.empty(); --i)
        if (i == 3) refused = clients[i]->receive_until("}\n");
    EXPECT_TRUE(refused.starts_with("HTTP/1.1 503 ")) << refused;
    hold = false;
    EXPECT_TRUE(clients[0]->receive_until("}\n").starts_with("HTTP/1.1 200 "));
}

TEST_F(WebServerTest, LimitsTheRateOfAnAddress) {
    const auto server = start({.burst = 3, .requests_per_second = 1});
    const Client client(server->port());
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(client.get("/quick").starts_with("HTTP/1.1 200 "));
    EXPECT_TRUE(client.get("/quick").starts_with("HTTP/1.1 429 "));
}

TEST_F(WebServerTest, AnswersConnectionsBeyondTheLimitWith503) {
    const auto server = start({.connections = 4});
    std::vector<std::unique_ptr<Client>> idle;
    for (int i = 0; i < 4; ++i) {
        idle.push_back(std::make_unique<Client>(server->port()));
        EXPECT_TRUE(idle.back()->get("/quick").starts_with("HTTP/1.1 200 "));
    }
    EXPECT_TRUE(Client(server->port()).get("/quick").starts_with("HTTP/1.1 503 "));
    EXPECT_TRUE(is_served_soon(*server)) << "the others are closed when they have been idle for some time";
}

// Those beyond the limit that never send anything hold their places no longer than the others.
TEST_F(WebServerTest, ClosesIdleConnectionsForNewOnes) {
    const auto server = start({.connections = 8});
    std::vector<std::unique_ptr<Client>> idle;
    for (int i = 0; i < 60; ++i) idle.push_back(std::make_unique<Client>(server->port()));
    ASSERT_TRUE(is_served_soon(*server));
    const Client first(server->port());
    const Client second(server->port());
    for (int i = 0; i < 10; ++i) {
        EXPECT_TRUE(first.get("/quick").starts_with("HTTP/1.1 200 "));
        EXPECT_TRUE(second.get("/quick").starts_with("HTTP/1.1 200 "));
    }
}

TEST_F(WebServerTest, BytesThatWereReceivedCountForTheirVisitor) {
    const auto server = start({.visitor_buffered = 50'000});
    const std::string change =
        "POST /api/v1/quick HTTP/1.1\r\nHost: localhost\r\nX-Takt: 1\r\n"
        "Content-Type: application/json\r\nContent-Length: ";
    const Client announces(server->port());
    announces.send(change + "16000000\r\n\r\n");
    std::unique_ptr<Client> sends;
    // Again, if the bytes of the second one came before those of the first.
    ASSERT_TRUE(comes([&] {
        sends = std::make_unique<Client>(server->port());
        sends->send(change + "60000\r\n\r\n" + std::string(49'990, ' '));
        std::this_thread::sleep_for(20ms);
        const Client greedy(server->port());
        greedy.send(change + "20\r\n\r\n" + std::string(20, ' '));
        return greedy.receive_until("}\n").starts_with("HTTP/1.1 429 ");
    }));
    const Client other(server->port(), "127.0.0.2");
    EXPECT_TRUE(other.get("/quick").starts_with("HTTP/1.1 200 "));
    sends->send("123456789012345");
    EXPECT_TRUE(sends->receive_until("}\n").starts_with("HTTP/1.1 429 "));
    EXPECT_TRUE(announces.receive_available().empty());
}

const std::string kPatient = "GET /api/v1/patient?client=a HTTP/1.1\r\nHost: localhost\r\n\r\n";

TEST_F(WebServerTest, StopsARequestWhoseClientHasGone) {
    const auto server = start();
    auto client = std::make_unique<Client>(server->port());
    client->send(kPatient);
    ASSERT_TRUE(comes([&] { return patient == 1; }));
    client.reset();
    EXPECT_TRUE(comes([&] { return ended == 1; }));
}

TEST_F(WebServerTest, StopsRequestsThatAreSuperseded) {
    const auto server = start();
    const Client first(server->port());
    first.send(kPatient);
    ASSERT_TRUE(comes([&] { return patient == 1; }));
    const Client second(server->port());
    second.send(kPatient);
    EXPECT_TRUE(first.receive_until("}\n").starts_with("HTTP/1.1 409 "));
    ASSERT_TRUE(comes([&] { return patient == 2; }));
    EXPECT_TRUE(server->stop()) << "a stop ends it, too";
    EXPECT_EQ(ended, 2);
}

TEST_F(WebServerTest, AStopDoesNotWaitForLong) {
    const auto server = start();
    const Client client(server->port());
    client.send("GET /api/v1/slow HTTP/1.1\r\nHost: localhost\r\n\r\n");
    ASSERT_TRUE(comes([&] { return slow == 1; }));
    const auto begin = Clock::now();
    EXPECT_FALSE(server->stop());
    EXPECT_LT(Clock::now() - begin, WebServer::kStopLimit + 2s);
    hold = false;
}

TEST_F(WebServerTest, ReportsAnAddressInUse) {
    const auto server = start();
    const auto second = WebServer::start({.address = {"127.0.0.1", server->port()}}, {}, {});
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, Code::cannot_open);
}

TEST_F(WebServerTest, ListensOnIpv6) {
    const auto server = WebServer::start({.address = {"::1", 0}}, {}, {});
    if (!server) GTEST_SKIP() << "no IPv6 here";
    EXPECT_EQ((*server)->url(), "http://[::1]:" + std::to_string((*server)->port()) + "/");
}

}  // namespace web_server_test
}  // namespace takt::web
