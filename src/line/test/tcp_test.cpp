// TCP client and server on the loopback interface.
#include <gtest/gtest.h>
#include <netinet/tcp.h>
#include <sys/resource.h>

#include "localhost.hpp"
#include "network/resolver.hpp"
#include "support.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/socket.hpp"
#include "takt/line/tcp_server.hpp"

namespace takt::line {
namespace tcp_test {

/// A session that answers "re:" and the request; "bye" makes it close the connection, after "wait" it
/// owes another answer, after "end" it sends nothing more.
class ScriptSession final : public Session {
public:
    explicit ScriptSession(int& alive) : alive_(alive) {
        ++alive_;
        engine_.reply = [](const std::string& request) { return "re:" + request; };
    }
    ~ScriptSession() override { --alive_; }
    Engine& engine() override { return engine_; }
    bool finished() const override { return engine_.input.ends_with("bye"); }
    bool output_ended() const override { return engine_.input.ends_with("end"); }
    bool drained() const override { return !engine_.input.ends_with("wait"); }
    Instant last_received() const override { return engine_.input.empty() ? accepted_ : now(); }

private:
    int& alive_;
    Instant accepted_ = now();
    ScriptEngine engine_;
};

struct Server {
    explicit Server(Loop& loop, const TcpServerOptions& options = {},
                    const ListenAddress& where = {"127.0.0.1", 0}) {
        const auto factory = [this](Instant, const Peer&) { return std::make_unique<ScriptSession>(alive); };
        server = std::move(TcpServer::listen(loop, where, factory, options)).value();
    }
    [[nodiscard]] std::uint16_t port() const { return server->port(); }

    int alive = 0;
    std::unique_ptr<TcpServer> server;
};

/// A client that the test holds outside the loop.
struct Client {
    explicit Client(std::uint16_t port, const char* from = "127.0.0.1")
        : fd(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        const auto own = resolve(from, 0, true).value().front();
        EXPECT_EQ(::bind(fd.get(), own.get(), own.length), 0);
        const auto address = resolve("127.0.0.1", port, true).value().front();
        EXPECT_EQ(::connect(fd.get(), address.get(), address.length), 0);
        ::fcntl(fd.get(), F_SETFL, O_NONBLOCK);
    }
    void write(const std::string& bytes) const {
        EXPECT_EQ(::send(fd.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
                  static_cast<ssize_t>(bytes.size()));
    }
    /// Takes what is there and notes the end.
    void read() {
        char buffer[4096];
        const ssize_t got = ::recv(fd.get(), buffer, sizeof buffer, 0);
        if (got > 0)
            input.append(buffer, static_cast<std::size_t>(got));
        else if (got == 0 || errno != EAGAIN)
            closed = true;
    }
    bool receives(Loop& loop, const std::string& wanted) {
        return run_until(loop, [&] {
            read();
            return input == wanted;
        });
    }
    bool is_closed(Loop& loop) {
        return run_until(loop, [&] {
            read();
            return closed;
        });
    }

    os::Descriptor fd;
    std::string input;
    bool closed = false;
};

TEST(TcpServer, ServesEachConnectionWithItsOwnEngine) {
    const auto loop = make_loop();
    const Server serving(*loop);
    EXPECT_EQ(serving.server->name(), "127.0.0.1:" + std::to_string(serving.port()));
    Client one(serving.port());
    Client other(serving.port());
    one.write("one");
    other.write("other");
    EXPECT_TRUE(one.receives(*loop, "re:one"));
    EXPECT_TRUE(other.receives(*loop, "re:other"));
    EXPECT_EQ(serving.server->connections(), 2u);
    one.fd.reset();
    EXPECT_TRUE(loop->run_until([&] { return serving.alive == 1; }, kDeadline));
    EXPECT_EQ(serving.server->counters().accepted, 2u);
    EXPECT_EQ(serving.server->counters().bytes_read, 3u);
    EXPECT_EQ(serving.server->counters().bytes_written, 6u);
}

TEST(TcpServer, ClosesWhenTheEngineHasFinishedAndItsAnswerIsSent) {
    const auto loop = make_loop();
    const Server serving(*loop);
    Client client(serving.port());
    client.write("bye");
    EXPECT_TRUE(client.is_closed(*loop));
    EXPECT_EQ(client.input, "re:bye");
    EXPECT_EQ(serving.alive, 0);
}

TEST(TcpServer, RefusesConnectionsBeyondItsLimitAndAcceptsAgain) {
    const auto loop = make_loop();
    TcpServerOptions options;
    options.max_connections = 1;
    const Server serving(*loop, options);
    Client first(serving.port());
    ASSERT_TRUE(loop->run_until([&] { return serving.alive == 1; }, kDeadline));
    Client second(serving.port());
    EXPECT_TRUE(second.is_closed(*loop));
    EXPECT_EQ(serving.server->counters().refused, 1u);
    first.fd.reset();
    ASSERT_TRUE(loop->run_until([&] { return serving.alive == 0; }, kDeadline));
    const Client third(serving.port());
    EXPECT_TRUE(loop->run_until([&] { return serving.alive == 1; }, kDeadline));
}

TEST(TcpServer, OneAddressTakesNoMoreThanItsShare) {
    const auto loop = make_loop();
    TcpServerOptions options;
    options.max_per_peer = 2;
    const Server serving(*loop, options, {"", 0});
    Client first(serving.port());
    const Client second(serving.port());
    ASSERT_TRUE(loop->run_until([&] { return serving.alive == 2; }, kDeadline));
    Client third(serving.port());
    EXPECT_TRUE(third.is_closed(*loop));
    EXPECT_EQ(serving.server->counters().over_peer_limit, 1u);
    EXPECT_EQ(serving.server->counters().refused, 1u);
    Client elsewhere(serving.port(), "127.0.0.2");
    elsewhere.write("me");
    EXPECT_TRUE(elsewhere.receives(*loop, "re:me")) << "another address has its own share";
    first.fd.reset();
    ASSERT_TRUE(loop->run_until([&] { return serving.alive == 2; }, kDeadline));
    Client again(serving.port());
    again.write("again");
    EXPECT_TRUE(again.receives(*loop, "re:again"));
}

TEST(TcpServer, AnAddressOfManyClientsHasNoShare) {
    const auto loop = make_loop();
    TcpServerOptions options;
    options.max_per_peer = 1;
    options.shared_peers = {*parse_network("127.0.0.0/31")};
    const Server serving(*loop, options);
    const Client first(serving.port());
    const Client second(serving.port());
    const Client third(serving.port());
    ASSERT_TRUE(loop->run_until([&] { return serving.alive == 3; }, kDeadline));
}

TEST(TcpServer, ClosesAnIdleConnectionOfTheGreatestHolderForANewOne) {
    const auto loop = make_loop();
    TcpServerOptions options;
    options.max_connections = 3;
    options.evict_after = 0ms;
    const Server serving(*loop, options, {"", 0});
    Client lonely(serving.port(), "127.0.0.2");
    ASSERT_TRUE(loop->run_until([&] { return serving.alive == 1; }, kDeadline));
    Client oldest(serving.port());
    ASSERT_TRUE(loop->run_until([&] { return serving.alive == 2; }, kDeadline));
    Client younger(serving.port());
    ASSERT_TRUE(loop->run_until([&] { return serving.alive == 3; }, kDeadline));
    Client late(serving.port(), "127.0.0.3");
    EXPECT_TRUE(oldest.is_closed(*loop));
    EXPECT_FALSE(lonely.closed) << "it is idle for longer, but the only one of its address";
    for (Client* const client : {&lonely, &younger, &late}) {
        client->write("me");
        EXPECT_TRUE(client->receives(*loop, "re:me"));
    }
    EXPECT_EQ(serving.server->counters().evicted, 1u);
    EXPECT_EQ(serving.server->counters().refused, 0u);
}

TEST(TcpServer, ClosesNoConnectionThatIsInUse) {
    const auto loop = make_loop();
    TcpServerOptions options;
    options.max_per_peer = 1;
    options.evict_after = 0ms;
    const Server serving(*loop, options);
    Client waiting(serving.port());
    waiting.write("wait");
    ASSERT_TRUE(waiting.receives(*loop, "re:wait"));
    Client second(serving.port());
    EXPECT_TRUE(second.is_closed(*loop));
    EXPECT_EQ(serving.server->counters().over_peer_limit, 1u);
    EXPECT_EQ(serving.server->counters().evicted, 0u);
}

TEST(TcpServer, AnswersAClientThatHasClosedItsSendingSide) {
    const auto loop = make_loop();
    const Server serving(*loop);
    Client client(serving.port());
    client.write("last");
    ::shutdown(client.fd.get(), SHUT_WR);
    EXPECT_TRUE(client.is_closed(*loop));
    EXPECT_EQ(client.input, "re:last");
    EXPECT_TRUE(loop->run_until([&] { return serving.alive == 0; }, kDeadline));
}

TEST(TcpServer, EndsItsSendingSideBeforeItCloses) {
    const auto loop = make_loop();
    const Server serving(*loop);
    Client client(serving.port());
    client.write("end");
    EXPECT_TRUE(client.is_closed(*loop));
    EXPECT_EQ(client.input, "re:end");
    EXPECT_EQ(serving.alive, 1);
    ::shutdown(client.fd.get(), SHUT_WR);
    EXPECT_TRUE(loop->run_until([&] { return serving.alive == 0; }, kDeadline));
}

TEST(TcpServer, ServesManyConnections) {
    constexpr std::size_t kMany = 200;
    const auto loop = make_loop();
    const Server serving(*loop);
    std::vector<Client> clients;
    for (std::size_t i = 0; i < kMany; ++i) clients.emplace_back(serving.port()).write(std::to_string(i));
    for (std::size_t i = 0; i < kMany; ++i)
        EXPECT_TRUE(clients[i].receives(*loop, "re:" + std::to_string(i)));
    EXPECT_EQ(serving.server->connections(), kMany);
}

// Takes every descriptor the process may have, and gives them back at the end.
class DescriptorFamine {
public:
    DescriptorFamine() {
        ::getrlimit(RLIMIT_NOFILE, &before_);
        rlimit few = before_;
        few.rlim_cur = 256;
        ::setrlimit(RLIMIT_NOFILE, &few);
        int fd = -1;
        while ((fd = ::open("/dev/null", O_RDONLY | O_CLOEXEC)) >= 0) taken_.emplace_back(fd);
    }
    ~DescriptorFamine() { ::setrlimit(RLIMIT_NOFILE, &before_); }
    void give_one() { taken_.pop_back(); }

private:
    rlimit before_{};
    std::vector<os::Descriptor> taken_;
};

TEST(TcpServer, GoesOnWithoutDescriptors) {
    const auto loop = make_loop();
    const Server serving(*loop);
    Client established(serving.port());
    ASSERT_TRUE(loop->run_until([&] { return serving.alive == 1; }, kDeadline));
    {
        DescriptorFamine famine;
        famine.give_one();
        Client hungry(serving.port());  // takes the last one
        EXPECT_TRUE(hungry.is_closed(*loop));
        EXPECT_EQ(serving.server->counters().refused, 1u);
        established.write("still there");
        EXPECT_TRUE(established.receives(*loop, "re:still there"));
    }
    Client after(serving.port());
    after.write("now");
    EXPECT_TRUE(after.receives(*loop, "re:now"));
}

TEST(TcpServer, ReadsNothingFromAClientThatDoesNotReadAndCutsItOff) {
    const auto loop = make_loop();
    TcpServerOptions options;
    options.write_limit = 50ms;
    const Server serving(*loop, options);
    const Client deaf(serving.port());
    Client other(serving.port());
    std::size_t offered = 0;
    EXPECT_TRUE(run_until(*loop, [&] {
        const std::string block(64 * 1024, 'x');
        const ssize_t taken = ::send(deaf.fd.get(), block.data(), block.size(), MSG_NOSIGNAL);
        if (taken > 0) offered += static_cast<std::size_t>(taken);
        return serving.server->counters().write_stalls == 1;
    }));
    EXPECT_LT(serving.server->counters().bytes_read, offered)
        << "the rest was left to the kernel to hold back";
    other.write("me too");
    EXPECT_TRUE(other.receives(*loop, "re:me too"));
}

TEST(TcpServer, SaysWhyItCannotListen) {
    const auto loop = make_loop();
    const Server serving(*loop);
    const auto second = TcpServer::listen(*loop, {"127.0.0.1", serving.port()}, {});
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error(),
              (Error{Code::cannot_open, std::string_view(serving.server->name()), {EADDRINUSE, 0, 0}}));
}

TEST(TcpServer, MayBeDestroyedWithItsConnections) {
    const auto loop = make_loop();
    Server serving(*loop);
    Client client(serving.port());
    ASSERT_TRUE(loop->run_until([&] { return serving.alive == 1; }, kDeadline));
    serving.server.reset();
    EXPECT_EQ(serving.alive, 0);
    EXPECT_TRUE(client.is_closed(*loop));
}

struct Linked {
    Linked() {
        options.on_link = [this](Instant, bool, const std::optional<Error>& why) { reported.push_back(why); };
    }

    ScriptEngine engine;
    std::vector<std::optional<Error>> reported;  // nothing: up
    DriverOptions options;
};

TEST(TcpDriver, ConnectsByNumberAndByName) {
    const auto loop = make_loop();
    const Server serving(*loop);
    for (const std::string host : {"127.0.0.1", "localhost"}) {
        if (host == "localhost" && !localhost_resolves()) GTEST_SKIP() << kNoLocalhost;
        Linked linked;
        linked.engine.output = {"hello"};
        const auto driver = connect_tcp(*loop, host, serving.port(), linked.engine, linked.options);
        EXPECT_TRUE(loop->run_until([&] { return linked.engine.input == "re:hello"; }, kDeadline)) << host;
        EXPECT_TRUE(driver->up());
        EXPECT_EQ(linked.engine.links, (std::vector{true}));
    }
}

TEST(TcpDriver, ConnectsOverIpv6) {
    const auto loop = make_loop();
    if (!TcpServer::listen(*loop, {"::1", 0}, {})) GTEST_SKIP() << "this machine has no IPv6";
    const Server serving(*loop, {}, {"::1", 0});
    Linked linked;
    linked.engine.output = {"six"};
    const auto driver = connect_tcp(*loop, "::1", serving.port(), linked.engine, linked.options);
    EXPECT_EQ(driver->name(), "[::1]:" + std::to_string(serving.port()));
    EXPECT_TRUE(loop->run_until([&] { return linked.engine.input == "re:six"; }, kDeadline));
}

TEST(TcpServer, ListensOnAllAddresses) {
    const auto loop = make_loop();
    const Server serving(*loop, {}, {"", 0});
    Linked linked;
    linked.engine.output = {"hello"};
    const auto driver = connect_tcp(*loop, "127.0.0.1", serving.port(), linked.engine, linked.options);
    EXPECT_TRUE(loop->run_until([&] { return linked.engine.input == "re:hello"; }, kDeadline));
}

TEST(TcpDriver, ComesBackByItself) {
    const auto loop = make_loop();
    auto serving = std::make_unique<Server>(*loop);
    const auto port = serving->port();
    Linked linked;
    const auto driver = connect_tcp(*loop, "127.0.0.1", port, linked.engine, linked.options);
    ASSERT_TRUE(loop->run_until([&] { return linked.engine.up(); }, kDeadline));
    linked.engine.output = {"x"};
    driver->poke();
    ASSERT_TRUE(loop->run_until([&] { return linked.engine.input == "re:x"; }, kDeadline));

    serving->server.reset();
    ASSERT_TRUE(loop->run_until([&] { return linked.reported.size() == 3; }, kDeadline))
        << "lost, and an attempt in vain";
    EXPECT_EQ(linked.reported[1]->code, Code::connection_lost);
    EXPECT_EQ(*linked.reported[2],
              (Error{Code::cannot_open, std::string_view(driver->name()), {ECONNREFUSED, 0, 0}}));
    EXPECT_FALSE(linked.engine.up());

    serving = std::make_unique<Server>(*loop, TcpServerOptions{}, ListenAddress{"127.0.0.1", port});
    ASSERT_TRUE(loop->run_until([&] { return linked.engine.up(); }, kDeadline));
    EXPECT_EQ(linked.engine.links, (std::vector{true, false, true}));
    EXPECT_EQ(driver->counters().links, 2u);
}

struct PlainListener {
    explicit PlainListener(int queue = 8) : fd(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        auto address = resolve("127.0.0.1", 0, true).value().front();
        EXPECT_EQ(::bind(fd.get(), address.get(), address.length), 0);
        EXPECT_EQ(::listen(fd.get(), queue), 0);
        EXPECT_EQ(::getsockname(fd.get(), address.get(), &address.length), 0);
        port = address.port();
    }
    os::Descriptor fd;
    std::uint16_t port = 0;
};

TEST(TcpDriver, ReadsWhatIsThereBeforeItWakesTheEngine) {
    const auto loop = make_loop();
    const PlainListener listener;
    Linked linked;
    const auto driver = connect_tcp(*loop, "127.0.0.1", listener.port, linked.engine, linked.options);
    ASSERT_TRUE(loop->run_until([&] { return linked.engine.up(); }, kDeadline));
    const os::Descriptor peer(::accept(listener.fd.get(), nullptr, nullptr));
    send_while_stopped(*loop, linked.engine, *driver,
                       [&] { EXPECT_EQ(::send(peer.get(), "in time", 7, MSG_NOSIGNAL), 7); });
    EXPECT_EQ(linked.engine.input_at_tick, "in time");
}

TEST(TcpDriver, EndsWhenThePeerHasClosedBeforeItWakesTheEngine) {
    const auto loop = make_loop();
    const PlainListener listener;
    Linked linked;
    const auto driver = connect_tcp(*loop, "127.0.0.1", listener.port, linked.engine, linked.options);
    ASSERT_TRUE(loop->run_until([&] { return linked.engine.up(); }, kDeadline));
    os::Descriptor peer(::accept(listener.fd.get(), nullptr, nullptr));
    const os::Descriptor other(::eventfd(1, EFD_CLOEXEC));
    Watch stop(*loop, other.get(), [&] {
        linked.engine.wakeup = now() + 1ms;
        driver->poke();
        peer.reset();
        std::this_thread::sleep_for(20ms);
    });
    stop.want_read();
    ASSERT_TRUE(loop->run_until([&] { return !driver->up(); }, kDeadline));
    EXPECT_TRUE(linked.engine.ticks.empty());
}

// A listener whose queue is full: the kernel drops further attempts without a word.
struct Swallower : PlainListener {
    Swallower() : PlainListener(0), waiting(std::make_unique<Client>(port)) {}
    std::unique_ptr<Client> waiting;
};

TEST(TcpDriver, AHostThatSwallowsAttemptsHoldsUpNoOther) {
    const auto loop = make_loop();
    const Swallower swallower;
    const Server serving(*loop);
    Linked dead;
    Linked alive;
    dead.options.connect_limit = 100ms;
    alive.engine.output = {"hello"};
    const auto lost = connect_tcp(*loop, "127.0.0.1", swallower.port, dead.engine, dead.options);
    const auto found = connect_tcp(*loop, "127.0.0.1", serving.port(), alive.engine, alive.options);
    ASSERT_TRUE(loop->run_until([&] { return alive.engine.input == "re:hello"; }, kDeadline));
    ASSERT_TRUE(loop->run_until([&] { return !dead.reported.empty(); }, kDeadline));
    EXPECT_EQ(*dead.reported[0],
              (Error{Code::cannot_open, std::string_view(lost->name()), {ETIMEDOUT, 0, 0}}));
    EXPECT_TRUE(found->up());
}

TEST(TcpDriver, SaysWhenANameIsUnknown) {
    const auto loop = make_loop();
    Linked linked;
    const std::string impossible(100, 'a');  // a label has at most 63 characters: no name service is asked
    const auto driver = connect_tcp(*loop, impossible, 502, linked.engine, linked.options);
    ASSERT_TRUE(loop->run_until([&] { return !linked.reported.empty(); }, kDeadline));
    EXPECT_EQ(linked.reported[0]->code, Code::cannot_open);
    EXPECT_LT(linked.reported[0]->numbers[0], 0) << "an error of the name service";
}

TEST(Resolver, MayBeForgotten) {
    const auto loop = make_loop();
    bool called = false;
    {
        const Resolver resolver(*loop, "localhost", 502, [&](auto) { called = true; });
    }
    {
        const Resolver resolver(*loop, "127.0.0.1", 502, [&](auto) { called = true; });
    }
    bool posted = false;
    loop->post([&] { posted = true; });
    EXPECT_TRUE(loop->run_until([&] { return posted; }, kDeadline));
    EXPECT_FALSE(called);
}

TEST(SocketAddress, SpellsAddresses) {
    EXPECT_EQ(resolve("10.0.0.5", 502, true).value().front().text(), "10.0.0.5:502");
    EXPECT_EQ(resolve("::1", 502, true).value().front().text(), "[::1]:502");
    EXPECT_EQ(resolve("::ffff:10.0.0.5", 502, true).value().front().text(), "10.0.0.5:502");
    EXPECT_FALSE(resolve("plc", 502, true));
}

// A peer with Nagle's algorithm keeps its next frame until the one before is acknowledged.
TEST(Socket, AcknowledgesAtOnceAfterEachRead) {
    auto loop = make_loop();
    Server server(*loop);
    auto fd = open_socket(AF_INET).value();
    const auto address = resolve("127.0.0.1", server.port(), true).value().front();
    ::connect(fd.get(), address.get(), address.length);
    SocketStream stream(std::move(fd), "server");
    stream.acknowledge_at_once();
    std::array<std::uint8_t, 16> buffer{};
    const std::array<std::uint8_t, 1> request{'x'};
    for (int i = 0; i < 20; ++i) {  // the kernel then expects a request that carries the acknowledgement
        std::size_t written = 0;
        run_until(*loop, [&] { return (written = stream.write(request).value_or(0)) > 0; });
        std::size_t got = 0;
        run_until(*loop, [&] { return (got = stream.read(buffer).value_or(0)) > 0; });
        int at_once = 0;
        socklen_t length = sizeof at_once;
        ASSERT_EQ(::getsockopt(stream.fd(), IPPROTO_TCP, TCP_QUICKACK, &at_once, &length), 0);
        EXPECT_EQ(at_once, 1) << i;
    }
}

}  // namespace tcp_test
}  // namespace takt::line
