// Handshakes of a server whose peers are silent, or speak TLS, inside the test.
#include "network/handshake.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>
#include <optional>
#include <vector>

#include "certificates.hpp"
#include "support.hpp"

namespace takt::line {
namespace handshake_test {

using namespace std::chrono_literals;

const tls::Identity kRoot = tls::make({.name = "Root"});
const tls::Identity kServer = tls::make({.usage = "serverAuth", .also = "DNS:localhost"}, &kRoot);
const tls::Identity kClient =
    tls::make({.name = "c", .usage = "clientAuth", .roles = {tls::utf8_string("Operator")}}, &kRoot);

std::shared_ptr<const tls::Context> context(tls::Side side, const tls::Identity& own) {
    const tls::Folder folder;
    auto loaded = tls::Context::load(side, folder.files(kRoot, own));
    EXPECT_TRUE(loaded);
    return *std::move(loaded);
}

/// A socket for the server, and the peer's end of it.
std::array<os::Descriptor, 2> sockets() {
    int both[2];
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, both), 0);
    return {os::Descriptor(both[0]), os::Descriptor(both[1])};
}

std::optional<Error> no_tls(std::string_view peer) {
    return Error{Code::tls_failed, peer, {static_cast<int>(TlsFault::not_tls), 0, 0}};
}

TEST(Handshakes, GiveTheStreamAndTheRole) {
    const auto loop = make_loop();
    Handshakes handshakes(*loop, context(tls::Side::server, kServer), 10s);
    auto [server, peer] = sockets();
    std::optional<std::string> role;
    handshakes.begin(std::move(server), "peer", [&](auto stream, const std::string& of_peer) {
        EXPECT_TRUE(stream);
        role = of_peer;
    });
    auto client = *tls::Connection::begin(context(tls::Side::client, kClient), peer.get(), "localhost", "s");
    loop->run_until(
        [&] {
            EXPECT_TRUE(client.handshake());
            return role.has_value();
        },
        10s);
    EXPECT_EQ(role, "Operator");
    EXPECT_EQ(handshakes.size(), 0U);
}

TEST(Handshakes, AFurtherOneEndsTheOldestSilentOne) {
    const auto loop = make_loop();
    Handshakes handshakes(*loop, context(tls::Side::server, kServer), 1h);
    std::vector<os::Descriptor> peers;
    std::vector<std::optional<Error>> ended(Handshakes::kMost + 1);
    for (std::size_t i = 0; i < ended.size(); ++i) {
        auto [server, peer] = sockets();
        peers.push_back(std::move(peer));
        handshakes.begin(std::move(server), "peer " + std::to_string(i),
                         [&ended, i](auto stream, const auto&) {
                             if (!stream) ended[i] = stream.error();
                         });
    }
    EXPECT_EQ(handshakes.size(), Handshakes::kMost);
    EXPECT_EQ(ended[0], no_tls("peer 0"));
    EXPECT_EQ(ended[1], std::nullopt);
}

TEST(Handshakes, EndAtTheirLimit) {
    const auto loop = make_loop();
    Handshakes handshakes(*loop, context(tls::Side::server, kServer), 1ms);
    auto [server, peer] = sockets();
    std::optional<Error> why;
    handshakes.begin(std::move(server), "peer", [&](auto stream, const auto&) {
        if (!stream) why = stream.error();
    });
    loop->run_until([&] { return why.has_value(); }, 10s);
    EXPECT_EQ(why, no_tls("peer"));
}

}  // namespace handshake_test
}  // namespace takt::line
