#include "takt/tls/connection.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "certificates.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::tls {
namespace connection_test {

const Identity kRoot = make({.name = "Root"});
const Identity kStranger = make({.name = "Stranger"});
const Wanted kServerWanted{.usage = "serverAuth", .also = "DNS:localhost,IP:127.0.0.1"};
const Wanted kClientWanted{.name = "client", .usage = "clientAuth", .roles = {utf8_string("Operator")}};
const Identity kServer = make(kServerWanted, &kRoot);
const Identity kClient = make(kClientWanted, &kRoot);

Wanted with(Wanted wanted, const std::function<void(Wanted&)>& change) {
    change(wanted);
    return wanted;
}

/// One side of a connection inside the test.
struct End {
    os::Descriptor socket;
    std::optional<Connection> connection;
    bool done = false;
    std::optional<Error> error;

    void step() {
        if (done || error) return;
        const auto progress = connection->handshake();
        if (!progress) error = progress.error();
        done = progress == Connection::Progress::done;
    }
    /// The fault of the handshake, or of the first read after it.
    [[nodiscard]] std::optional<TlsFault> fault() {
        std::array<std::uint8_t, 16> buffer{};
        if (!error && done) {
            const auto got = connection->read(buffer);
            if (!got) error = got.error();
        }
        if (!error || error->code != Code::tls_failed) return std::nullopt;
        return static_cast<TlsFault>(error->numbers[0]);
    }
};

struct Pair {
    End client;
    End server;

    Pair(std::shared_ptr<const Context> client_context, std::shared_ptr<const Context> server_context,
         const std::string& host) {
        int sockets[2];
        EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, sockets), 0);
        client.socket = os::Descriptor(sockets[0]);
        server.socket = os::Descriptor(sockets[1]);
        client.connection.emplace(
            *Connection::begin(std::move(client_context), sockets[0], host, "server:802"));
        server.connection.emplace(
            *Connection::begin(std::move(server_context), sockets[1], {}, "client:5000"));
        for (int turn = 0; turn < 10; ++turn) {
            client.step();
            server.step();
        }
    }
};

std::shared_ptr<const Context> context(Side side, const model::TlsFiles& files) {
    auto loaded = Context::load(side, files);
    EXPECT_TRUE(loaded) << loaded.error().subject.view();
    return *std::move(loaded);
}

TEST(Connection, CarriesBytesAndTheRole) {
    const Folder server, client;
    Pair pair(context(Side::client, client.files(kRoot, kClient)),
              context(Side::server, server.files(kRoot, kServer)), "localhost");
    ASSERT_TRUE(pair.client.done && pair.server.done);
    EXPECT_EQ(pair.server.connection->role(), "Operator");
    EXPECT_EQ(pair.client.connection->role(), "");
    const std::vector<std::uint8_t> sent(3000, 0x5A);
    EXPECT_EQ(pair.client.connection->write(sent), sent.size());
    std::vector<std::uint8_t> got(1000);
    EXPECT_EQ(pair.server.connection->read(got), 1000U);
    EXPECT_TRUE(pair.server.connection->has_buffered());  // the record has more than was asked for
    EXPECT_EQ(pair.server.connection->read(got), 1000U);
    EXPECT_EQ(pair.server.connection->read(got), 1000U);
    EXPECT_FALSE(pair.server.connection->has_buffered());
    EXPECT_EQ(pair.server.connection->read(got), 0U);
    pair.client.connection.reset();
    const auto ended = pair.server.connection->read(got);
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error(), (Error{Code::connection_lost, "client:5000", {}}));
}

TEST(Connection, RefusesEveryCertificateThatIsWrong) {
    const Folder folder;
    struct Case {
        const char* what;
        Identity client;
        TlsFault at_server;
        TlsFault at_client;
    };
    const auto client = [](const std::function<void(Wanted&)>& change) {
        return make(with(kClientWanted, change), &kRoot);
    };
    const Identity revoked = make(kClientWanted, &kRoot);
    const Case cases[] = {
        {"another root", make(kClientWanted, &kStranger), TlsFault::untrusted, TlsFault::refused_untrusted},
        {"signed by itself", make(kClientWanted), TlsFault::untrusted, TlsFault::refused_untrusted},
        {"expired", client([](auto& w) { w.ends = -60; }), TlsFault::expired, TlsFault::refused_expired},
        {"not yet valid", client([](auto& w) { w.begins = 3600; }), TlsFault::not_yet_valid,
         TlsFault::refused},
        {"a server's", client([](auto& w) { w.usage = "serverAuth"; }), TlsFault::purpose, TlsFault::refused},
        {"revoked", revoked, TlsFault::revoked, TlsFault::refused_revoked},
    };
    for (const auto& wrong : cases) {
        SCOPED_TRACE(wrong.what);
        const Folder server, other;
        auto files = server.files(kRoot, kServer);
        files.crl = server.write_list("ca.crl", kRoot, {revoked});
        Pair pair(context(Side::client, other.files(kRoot, wrong.client)), context(Side::server, files),
                  "localhost");
        EXPECT_FALSE(pair.server.done);
        EXPECT_EQ(pair.server.fault(), wrong.at_server);
        EXPECT_EQ(pair.client.fault(), wrong.at_client);
    }
}

TEST(Connection, DemandsTheServerThatWasAskedFor) {
    struct Case {
        const char* what;
        Identity server;
        const char* host;
        std::optional<TlsFault> fault;
    };
    const auto server = [](const std::function<void(Wanted&)>& change) {
        return make(with(kServerWanted, change), &kRoot);
    };
    const Case cases[] = {
        {"by its name", kServer, "localhost", std::nullopt},
        {"by its address", kServer, "127.0.0.1", std::nullopt},
        {"another name", kServer, "plc.example", TlsFault::other_name},
        {"another address", kServer, "127.0.0.2", TlsFault::other_name},
        {"another root", make(kServerWanted, &kStranger), "localhost", TlsFault::untrusted},
        {"expired", server([](auto& w) { w.ends = -60; }), "localhost", TlsFault::expired},
        {"a client's", server([](auto& w) { w.usage = "clientAuth"; }), "localhost", TlsFault::purpose},
    };
    for (const auto& one : cases) {
        SCOPED_TRACE(one.what);
        const Folder own, other;
        Pair pair(context(Side::client, own.files(kRoot, kClient)),
                  context(Side::server, other.files(kRoot, one.server)), one.host);
        EXPECT_EQ(pair.client.fault(), one.fault);
        EXPECT_EQ(pair.client.done, !one.fault);
    }
}

TEST(Connection, MayExpectAnotherName) {
    const Folder own, other;
    auto files = own.files(kRoot, kClient);
    files.server_name = "localhost";
    Pair pair(context(Side::client, files), context(Side::server, other.files(kRoot, kServer)), "10.0.0.5");
    EXPECT_TRUE(pair.client.done);
}

TEST(Connection, WithoutAListOfTheIssuerNothingIsTrusted) {
    const Folder own, other;
    auto files = other.files(kRoot, kServer);
    files.crl = other.write_list("ca.crl", kStranger, {});
    Pair pair(context(Side::client, own.files(kRoot, kClient)), context(Side::server, files), "localhost");
    EXPECT_EQ(pair.server.fault(), TlsFault::revocation_list);
}

TEST(Connection, NamesAPeerWithoutTls) {
    const Folder own;
    const auto wanted = context(Side::client, own.files(kRoot, kClient));
    int sockets[2];
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, sockets), 0);
    const os::Descriptor plain(sockets[1]);
    End client{.socket = os::Descriptor(sockets[0]), .connection = std::nullopt};
    client.connection.emplace(*Connection::begin(wanted, sockets[0], "localhost", "server:502"));
    client.step();
    const std::array<std::uint8_t, 9> answer{0, 1, 0, 0, 0, 3, 1, 0x83, 1};
    ASSERT_EQ(::send(plain.get(), answer.data(), answer.size(), 0), 9);
    client.step();
    EXPECT_EQ(client.fault(), TlsFault::not_tls);
}

}  // namespace connection_test
}  // namespace takt::tls
