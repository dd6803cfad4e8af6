#include "takt/serve/route_table.hpp"

#include <gtest/gtest.h>

#include "rig.hpp"

namespace takt::serve {
namespace route_table_test {

using namespace test;

struct Routed {
    explicit Routed(const std::vector<Route>& all)
        : routes(1, {{&a, {}, [this] { ++asked; }}, {&b, {}, {}}}, all) {
        a.on_link(true);
        b.on_link(true);
    }
    std::optional<wire::Pdu> ask(int unit, serve::Token token, std::string_view peer = "192.0.2.1:5") {
        return routes.ask({at(1s), UnitId{static_cast<std::uint8_t>(unit)}, false, peer, {}},
                          wire::RequestView(pdu("06 00 00 00 01").span()), token);
    }
    Gateway a;
    Gateway b;
    int asked = 0;
    RouteTable routes;
};

std::string unit_of(Gateway& gateway) {
    const auto sent = gateway.next(at(1s));
    return sent ? std::to_string(sent->unit.value) : "";
}

TEST(RouteTable, TheFirstRouteOfAUnitCounts) {
    Routed routed({{UnitId{5}, UnitId{17}, 0}, {UnitId{5}, UnitId{18}, 1}, {UnitId{6}, UnitId{6}, 1}});
    EXPECT_FALSE(routed.routes.has(UnitId{7}));
    EXPECT_FALSE(routed.routes.has(UnitId{0}));
    ASSERT_TRUE(routed.routes.has(UnitId{5}));
    EXPECT_FALSE(routed.ask(5, 1));
    EXPECT_EQ(routed.asked, 1);
    EXPECT_EQ(unit_of(routed.a), "17");
    EXPECT_FALSE(routed.ask(6, 2));
    EXPECT_EQ(unit_of(routed.b), "6");
    EXPECT_EQ(routed.asked, 1) << "the other line";
}

TEST(RouteTable, AnswersAtOnceWhereTheLineIsClosed) {
    Routed routed({{UnitId{5}, UnitId{17}, 0}});
    routed.a.on_link(false);
    const auto answer = routed.ask(5, 1);
    ASSERT_TRUE(answer);
    EXPECT_EQ(hex(answer->span()), "86 0A");
    EXPECT_EQ(routed.asked, 0);
}

// Two connections of one peer have one turn each round, those of two peers one each.
TEST(RouteTable, AnIpv6NetworkIsOnePeer) {
    Routed routed({{UnitId{1}, UnitId{1}, 0}, {UnitId{2}, UnitId{2}, 0}, {UnitId{3}, UnitId{3}, 0}});
    (void)routed.ask(1, 1, "[2001:db8::1]:1");
    (void)routed.ask(2, 2, "[2001:db8::2]:2");
    (void)routed.ask(3, 3, "[2001:db8:0:1::1]:3");
    std::string order;
    while (const auto sent = routed.a.next(at(1s))) {
        order += std::to_string(sent->unit.value);
        routed.a.on_outcome({.id = sent->id, .response = wire::ResponseView(sent->request.pdu())});
        while (routed.a.take_reply()) continue;
    }
    EXPECT_EQ(order, "132") << "another network goes before the second address of the first";
}

TEST(RouteTable, ConnectionsAreRequesters) {
    Routed routed({{UnitId{5}, UnitId{5}, 0}, {UnitId{6}, UnitId{6}, 0}});
    (void)routed.ask(5, 1, "192.0.2.1:1");
    (void)routed.ask(5, 2, "192.0.2.1:1");
    (void)routed.ask(6, 3, "192.0.2.1:2");
    const auto first = routed.a.next(at(1s));
    routed.a.on_outcome({.id = first->id, .response = wire::ResponseView(first->request.pdu())});
    EXPECT_EQ(unit_of(routed.a), "6");
    const auto reply = routed.a.take_reply();
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->server, 1u);
    EXPECT_EQ(reply->token, 1u);
}

TEST(RouteTable, ForgetsARequest) {
    Routed routed({{UnitId{5}, UnitId{5}, 1}});
    (void)routed.ask(5, 9);
    EXPECT_EQ(routed.b.waiting(), 1u);
    routed.routes.forget(8);
    EXPECT_EQ(routed.b.waiting(), 1u);
    routed.routes.forget(9);
    EXPECT_EQ(routed.b.waiting(), 0u);
}

}  // namespace route_table_test
}  // namespace takt::serve
