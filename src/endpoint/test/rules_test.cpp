// Access rules against the bytes on the line: every function, own or relayed, for every kind of rule; and
// random rules with random requests.
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "rules_world.hpp"

namespace takt::endpoint {
namespace rules_test {

using takt::test::Pdu;
using takt::test::RulesWorld;
using takt::test::RuleText;

std::string text_of(const std::vector<RuleText>& rules, std::size_t client, int unit, const Pdu& pdu) {
    std::string text = "client " + std::string(takt::test::clients()[client].peer) + ", unit " +
                       std::to_string(unit) + ", request";
    for (const auto byte : pdu) text += " " + std::to_string(byte);
    for (const auto& rule : rules) text += "\n" + rule.yaml();
    return text;
}

/// One request of each function, also undefined ones and such that have not the length of their function.
std::vector<Pdu> all_functions() {
    std::vector<Pdu> all{
        {1, 0, 5, 0, 2},
        {2, 0, 5, 0, 2},
        {3, 0, 5, 0, 2},
        {4, 0, 5, 0, 2},
        {5, 0, 5, 0xFF, 0},
        {6, 0, 5, 0, 7},
        {7},
        {11},
        {12},
        {15, 0, 5, 0, 2, 1, 3},
        {16, 0, 5, 0, 2, 4, 0, 1, 0, 2},
        {17},
        {20, 7, 6, 0, 4, 0, 1, 0, 2},
        {21, 9, 6, 0, 4, 0, 1, 0, 1, 0, 9},
        {22, 0, 5, 0, 0xF2, 0, 0x25},
        {23, 0, 5, 0, 1, 0, 90, 0, 1, 2, 0, 9},
        {23, 0, 90, 0, 1, 0, 5, 0, 1, 2, 0, 9},
        {24, 0, 5},
        {43, 14, 1, 0},
        {43, 13, 0, 0, 1},
        {43, 255},
        {0},
        {0x83, 2},
        // Over the last item.
        {3, 255, 255, 0, 7},
        {16, 255, 255, 0, 2, 4, 0, 1, 0, 2},
        {15, 255, 251, 0, 16, 2, 3, 3},
        {23, 0, 90, 0, 1, 255, 255, 0, 7, 14, 0, 9, 0, 9, 0, 9, 0, 9, 0, 9, 0, 9, 0, 9},
        // Of another length than their function has.
        {6, 0, 5},
        {6, 0, 5, 0, 7, 0},
        {3, 0, 5, 0, 2, 0},
        {3, 0, 5, 0, 0},
        {16, 0, 90, 0, 1, 4, 0, 1, 0, 2},
        {16, 0, 90, 0, 2, 2, 0, 1},
        {16, 0, 5, 0, 0, 0},
        {22, 0, 5},
        {23, 0, 90, 0, 1, 0, 90, 0, 1, 4, 0, 9, 0, 9},
        {24, 0, 5, 0},
        {43},
        {8},
        {7, 0},
    };
    for (int sub = 0; sub <= 22; ++sub) all.push_back({8, 0, static_cast<std::uint8_t>(sub), 0, 0});
    all.push_back({8, 1, 0, 0, 0});
    for (int code = 65; code <= 72; ++code) all.push_back({static_cast<std::uint8_t>(code), 0, 5, 0, 7});
    for (int code = 100; code <= 110; ++code) all.push_back({static_cast<std::uint8_t>(code)});
    return all;
}

/// Every kind of rule, each against something that is allowed.
std::vector<std::vector<RuleText>> all_kinds() {
    const RuleText allow;
    const auto before_allow = [&](RuleText rule) { return std::vector{std::move(rule), allow}; };
    std::vector<std::vector<RuleText>> all{{}, {allow}, {{.rule = "deny"}}, {{.rule = "read_only"}}};
    for (const auto& rule : {"deny", "read_only", "allow"}) {
        for (const auto& unit : {std::pair{5, 5}, std::pair{3, 3}, std::pair{0, 0}, std::pair{7, 7},
                                 std::pair{30, 31}, std::pair{200, 200}})
            all.push_back(before_allow({.units = {unit}, .rule = rule}));
        for (const char* const function : {"read", "write", "43", "6", "65", "8"})
            all.push_back(before_allow({.functions = {function}, .rule = rule}));
        for (int area = 0; area < 4; ++area) {
            all.push_back(before_allow({.area = area, .items = {{0, 5}}, .rule = rule}));
            all.push_back(before_allow({.area = area, .items = {{6, 6}, {65535, 65535}}, .rule = rule}));
            all.push_back(before_allow({.units = {{5, 5}}, .area = area, .rule = rule}));
        }
        for (const char* const peer : {"192.0.2.7", "::ffff:192.0.2.0/120", "2001:db8::/32", "serial"})
            all.push_back(before_allow({.peers = {peer}, .rule = rule}));
    }
    for (const char* const functions : {"read", "write", "43", "6"}) {
        all.push_back({{.functions = {functions}}});
        all.push_back({{.units = {{1, 255}}, .functions = {functions}}});
    }
    all.push_back({{.functions = {"read", "write"}}});
    all.push_back({{.units = {{5, 5}}}});
    all.push_back({{.units = {{1, 247}}}});
    all.push_back({{.area = takt::test::kHolding}});
    all.push_back({{.area = takt::test::kHolding},
                   {.area = takt::test::kCoil},
                   {.area = takt::test::kInput},
                   {.area = takt::test::kDiscrete}});
    all.push_back({{.units = {{3, 3}}, .rule = "deny"}, {.functions = {"read"}}, {.rule = "read_only"}});
    all.push_back({{.rate = 3}});
    all.push_back({{.area = takt::test::kHolding, .items = {{0, 5}}, .rate = 2}, {.rate = 4}});
    all.push_back({{.units = {{5, 9}}, .rate = 1}, {.rate = 50}});
    return all;
}

// Every function to every unit, by every kind of client, under every kind of rule.
TEST(RulesOnTheWire, AreWhatTheyAllow) {
    RulesWorld world;
    std::size_t sent = 0;
    std::size_t refused = 0;
    const auto functions = all_functions();
    for (const auto& rules : all_kinds()) {
        ASSERT_TRUE(world.set(rules));
        std::size_t turn = 0;
        for (const int unit : RulesWorld::kUnits)
            for (const auto& pdu : functions) {
                const std::size_t client = turn++ % takt::test::clients().size();
                const bool serial = takt::test::clients()[client].peer[0] == '/';
                const auto result = world.ask(client, unit, pdu);
                ASSERT_EQ(result.seen, result.expected) << text_of(rules, client, unit, pdu);
                ASSERT_TRUE(RulesWorld::answered_right(result, pdu, serial && unit == 0))
                    << text_of(rules, client, unit, pdu);
                sent += result.seen.size();
                refused += result.refused_by_rule ? 1U : 0U;
            }
    }
    EXPECT_GT(sent, 10'000u);
    EXPECT_GT(refused, 10'000u);
}

/// Numbers near each other and near the end, so that rules and requests meet.
int place() {
    return *rc::gen::oneOf(rc::gen::inRange(0, 12), rc::gen::inRange(65530, 65536),
                           rc::gen::inRange(0, 65536));
}

std::pair<int, int> range(int greatest) {
    const int first = std::min(place(), greatest);
    return {first, std::min(first + *rc::gen::inRange(0, 6), greatest)};
}

RuleText random_rule() {
    RuleText rule;
    if (*rc::gen::inRange(0, 3) == 0)
        rule.peers = {*rc::gen::element<std::string>("192.0.2.7", "192.0.2.0/24", "::ffff:192.0.2.0/120",
                                                     "2001:db8::/32", "::/0", "serial")};
    for (int i = *rc::gen::inRange(-2, 3); i > 0; --i)
        rule.units.push_back(*rc::gen::element(std::pair{0, 0}, std::pair{0, 255}, std::pair{1, 255},
                                               std::pair{3, 3}, std::pair{4, 5}, std::pair{5, 5},
                                               std::pair{7, 7}, std::pair{6, 247}, std::pair{200, 255}));
    for (int i = *rc::gen::inRange(-2, 3); i > 0; --i)
        rule.functions.push_back(
            *rc::gen::element<std::string>("read", "write", "3", "6", "16", "23", "43", "65", "8", "110"));
    if (*rc::gen::inRange(0, 2) == 0) {
        rule.area = *rc::gen::inRange(0, 4);
        for (int i = *rc::gen::inRange(0, 4); i > 0; --i) rule.items.push_back(range(65535));
        std::ranges::sort(rule.items);
    }
    rule.rule = *rc::gen::element<std::string>("allow", "allow", "read_only", "deny");
    if (*rc::gen::inRange(0, 4) == 0) rule.rate = *rc::gen::inRange(1, 5);
    return rule;
}

Pdu random_request() {
    static const auto functions = all_functions();
    Pdu pdu = *rc::gen::elementOf(functions);
    const auto put = [&](std::size_t at, int value) {
        if (at + 1 >= pdu.size()) return;
        pdu[at] = static_cast<std::uint8_t>(value >> 8);
        pdu[at + 1] = static_cast<std::uint8_t>(value);
    };
    if (pdu[0] != 8 && pdu[0] != 43 && pdu[0] != 20 && pdu[0] != 21) put(1, place());
    if (pdu[0] == 23) put(5, place());
    if (pdu[0] <= 4) put(3, *rc::gen::inRange(0, 9));
    if (*rc::gen::inRange(0, 10) == 0) pdu.push_back(*rc::gen::arbitrary<std::uint8_t>());
    if (pdu.size() > 1 && *rc::gen::inRange(0, 10) == 0) pdu.pop_back();
    return pdu;
}

TEST(RulesOnTheWireProperties, WhatReachesTheLineIsWhatTheRulesAllow) {
    EXPECT_TRUE(rc::check([] {
        RulesWorld world;
        std::vector<RuleText> rules;
        for (int i = *rc::gen::inRange(0, 6); i > 0; --i) rules.push_back(random_rule());
        RC_PRE(world.set(rules));
        for (int i = 0; i < 40; ++i) {
            const auto client = *rc::gen::inRange<std::size_t>(0, takt::test::clients().size());
            const int unit =
                *rc::gen::elementOf(std::vector(RulesWorld::kUnits.begin(), RulesWorld::kUnits.end()));
            const Pdu pdu = random_request();
            const auto result = world.ask(client, unit, pdu);
            if (result.seen != result.expected) RC_FAIL(text_of(rules, client, unit, pdu));
            const bool broadcast = takt::test::clients()[client].peer[0] == '/' && unit == 0;
            RC_ASSERT(RulesWorld::answered_right(result, pdu, broadcast));
        }
    }));
}

}  // namespace rules_test
}  // namespace takt::endpoint
