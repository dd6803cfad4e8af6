#include "takt/relay/relay_responder.hpp"

#include <gtest/gtest.h>

#include "rig.hpp"
#include "takt/serve/tcp_connection.hpp"

namespace takt::relay {
namespace {

using namespace test;

/// Answers for unit 1 with its number, and for 0 and 255, as a server does.
struct Own final : serve::Responder {
    [[nodiscard]] bool serves(UnitId unit) const override { return unit == UnitId{1}; }
    [[nodiscard]] serve::Answer handle(const serve::Context& context, Bytes request) override {
        broadcasts += context.broadcast ? 1 : 0;
        const bool here = serves(context.unit) || context.unit.value == 0 || context.unit.value == 255;
        return serve::Answer::response(
            here ? pdu("03 02 00 01")
                 : serve::exception_to(request[0], wire::ExceptionCode::gateway_path_unavailable));
    }
    void forget(serve::Token token) override { forgotten = token; }
    int broadcasts = 0;
    serve::Token forgotten = 0;
};

struct Relaying {
    explicit Relaying(const std::vector<Route>& routes)
        : responder(1, &own, tokens, {{&a, {}, [this] { ++asked; }}, {&b, {}, {}}}, routes) {
        a.on_link(true);
        b.on_link(true);
    }
    serve::Answer ask(int unit, bool broadcast = false, std::string_view peer = "192.0.2.1:5") {
        return responder.handle({at(1s), UnitId{static_cast<std::uint8_t>(unit)}, broadcast, peer, {}},
                                pdu("06 00 00 00 01").span());
    }
    Own own;
    serve::Tokens tokens;
    Gateway a;
    Gateway b;
    int asked = 0;
    RelayResponder responder;
};

std::string unit_of(Gateway& gateway) {
    const auto sent = gateway.next(at(1s));
    return sent ? std::to_string(sent->unit.value) : "";
}

TEST(RelayResponder, RoutesByUnit) {
    Relaying relaying({{UnitId{5}, UnitId{17}, 0},
                       {UnitId{5}, UnitId{18}, 1},
                       {UnitId{6}, UnitId{6}, 1},
                       {UnitId{1}, UnitId{1}, 0}});
    EXPECT_EQ(hex(relaying.ask(1).pdu.span()), "03 02 00 01") << "an own unit goes first";
    EXPECT_EQ(hex(relaying.ask(255).pdu.span()), "03 02 00 01");
    EXPECT_EQ(hex(relaying.ask(7).pdu.span()), "86 0A");
    const auto five = relaying.ask(5);
    EXPECT_EQ(five.kind, serve::Answer::Kind::pending);
    EXPECT_NE(five.token, relaying.tokens.next()) << "the token is taken";
    EXPECT_EQ(relaying.asked, 1);
    EXPECT_EQ(unit_of(relaying.a), "17");
    EXPECT_NE(relaying.ask(6).token, five.token);
    EXPECT_EQ(unit_of(relaying.b), "6");
    EXPECT_TRUE(relaying.responder.serves(UnitId{6}));
    EXPECT_FALSE(relaying.responder.serves(UnitId{7}));
}

TEST(RelayResponder, ConnectionsAreClients) {
    Relaying relaying({{UnitId{5}, UnitId{5}, 0}, {UnitId{6}, UnitId{6}, 0}});
    (void)relaying.ask(5, false, "192.0.2.1:1");
    (void)relaying.ask(5, false, "192.0.2.1:1");
    (void)relaying.ask(6, false, "192.0.2.1:2");
    const auto first = relaying.a.next(at(1s));
    relaying.a.on_outcome({.id = first->id, .response = first->request});
    EXPECT_EQ(unit_of(relaying.a), "6");
}

TEST(RelayResponder, BroadcastsOfASerialLineGoOnWhereUnit0IsRouted) {
    Relaying without({{UnitId{5}, UnitId{5}, 0}});
    EXPECT_EQ(without.ask(0, true).kind, serve::Answer::Kind::silence);
    EXPECT_EQ(without.own.broadcasts, 1);
    EXPECT_EQ(unit_of(without.a), "");
    Relaying with({{UnitId{0}, UnitId{0}, 0}});
    EXPECT_EQ(with.ask(0, true).kind, serve::Answer::Kind::silence);
    EXPECT_EQ(with.own.broadcasts, 1);
    EXPECT_EQ(unit_of(with.a), "0");
}

TEST(RelayResponder, ForgetsWithWhomeverItIs) {
    Relaying relaying({{UnitId{5}, UnitId{5}, 1}});
    const auto token = relaying.ask(5).token;
    relaying.responder.forget(token);
    EXPECT_EQ(relaying.b.waiting(), 0u);
    EXPECT_EQ(relaying.own.forgotten, token) << "whose it is they know themselves";
}

TEST(RelayResponder, AConnectionGetsTheAnswerToItsRequestUnderItsTransactionId) {
    Relaying relaying({{UnitId{5}, UnitId{17}, 0}});
    serve::TcpConnection connection({}, relaying.responder);
    connection.on_link(at(1s), true);
    const std::uint8_t request[] = {0x12, 0x34, 0, 0, 0, 6, 5, 3, 0, 0, 0, 1};
    connection.on_bytes(at(1s), request);
    EXPECT_TRUE(connection.transmit(at(1s)).empty());
    const auto sent = relaying.a.next(at(1s));
    ASSERT_TRUE(sent);
    EXPECT_EQ(sent->unit, UnitId{17});
    relaying.a.on_outcome({.id = sent->id, .response = pdu("03 02 00 2A")});
    const auto reply = relaying.a.take_reply();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->server, 1u);
    EXPECT_TRUE(connection.complete(at(1s), reply->token, reply->pdu.span()));
    EXPECT_EQ(hex(connection.transmit(at(1s))), "12 34 00 00 00 05 05 03 02 00 2A");
}

}  // namespace
}  // namespace takt::relay
