// Access rules: each rule, and all against a plain reference that checks each item by itself.
#include "takt/serve/access.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <string>
#include <vector>

namespace takt::serve {
namespace access_test {

using namespace std::chrono_literals;
using Decision = AccessControl::Decision;
using Permission = AccessRule::Permission;
using wire::Area;

using Request = std::vector<std::uint8_t>;

Request request(std::initializer_list<int> bytes) {
    return {bytes.begin(), bytes.end()};
}
Request read_holding(int first, int count) {
    return request({3, first >> 8, first & 255, count >> 8, count & 255});
}
Request write_holding(int address) {
    return request({6, address >> 8, address & 255, 0, 1});
}

constexpr std::string_view kPeer = "192.0.2.7:50100";

struct Rules {
    Decision decide(const Request& bytes, std::string_view peer = kPeer, int unit = 1, Instant t = Instant{},
                    std::string_view role = {}) {
        const Context context{t, UnitId{static_cast<std::uint8_t>(unit)}, false, peer, role};
        return control.decide(context, context.unit, wire::RequestView(bytes));
    }
    void set(std::vector<AccessRule> with) {
        rules = std::move(with);
        control.set_rules(rules);
    }
    std::vector<AccessRule> rules;
    std::array<RateBucket, 4> buckets;
    AccessControl control{buckets};
};

FunctionSet functions(std::initializer_list<int> codes) {
    FunctionSet set;
    for (const int code : codes) set.add(static_cast<std::uint8_t>(code));
    return set;
}

TEST(Access, WithoutRulesEverythingIsAllowed) {
    Rules rules;
    EXPECT_EQ(rules.decide(write_holding(1)), Decision::allowed);
    EXPECT_EQ(rules.decide(request({0x63})), Decision::allowed);
}

TEST(Access, WithRulesWhatNoneSpeaksOfIsDenied) {
    Rules rules;
    const std::array units{UnitRange{2, 3}};
    rules.set({{.units = units, .permission = Permission::allow}});
    EXPECT_EQ(rules.decide(read_holding(0, 1), kPeer, 1), Decision::denied);
    EXPECT_EQ(rules.decide(read_holding(0, 1), kPeer, 2), Decision::allowed);
    EXPECT_EQ(rules.decide(read_holding(0, 1), kPeer, 3), Decision::allowed);
    EXPECT_EQ(rules.decide(read_holding(0, 1), kPeer, 4), Decision::denied);
}

TEST(Access, TheFirstRuleThatFitsCounts) {
    Rules rules;
    rules.set(
        {{.functions = functions({6}), .permission = Permission::deny}, {.permission = Permission::allow}});
    EXPECT_EQ(rules.decide(write_holding(0)), Decision::denied);
    EXPECT_EQ(rules.decide(read_holding(0, 1)), Decision::allowed);
    std::swap(rules.rules[0], rules.rules[1]);
    EXPECT_EQ(rules.decide(write_holding(0)), Decision::allowed);
}

TEST(Access, RolesOfCertificates) {
    Rules rules;
    const std::array<std::string_view, 2> writers{"Operator", "Engineer"};
    const std::array<std::string_view, 1> without_role{""};
    rules.set({{.roles = writers, .permission = Permission::allow},
               {.roles = without_role, .permission = Permission::read_only}});
    EXPECT_EQ(rules.decide(write_holding(0), kPeer, 1, {}, "Operator"), Decision::allowed);
    EXPECT_EQ(rules.decide(write_holding(0), kPeer, 1, {}, "operator"), Decision::denied);
    EXPECT_EQ(rules.decide(write_holding(0), kPeer, 1, {}, "Operator "), Decision::denied);
    EXPECT_EQ(rules.decide(write_holding(0), kPeer, 1, {}, ""), Decision::read_only);
    EXPECT_EQ(rules.decide(read_holding(0, 1), kPeer, 1, {}, ""), Decision::allowed);
    EXPECT_EQ(rules.decide(read_holding(0, 1), kPeer, 1, {}, "Viewer"), Decision::denied);
}

TEST(Access, PeersByTheirNetworkOrSerialPort) {
    Rules rules;
    const std::array networks{*parse_network("192.0.2.0/24"), *parse_network("2001:db8::/32")};
    rules.set({{.networks = networks, .every_peer = false, .permission = Permission::allow}});
    EXPECT_EQ(rules.decide(read_holding(0, 1)), Decision::allowed);
    EXPECT_EQ(rules.decide(read_holding(0, 1), "[2001:db8::9]:1"), Decision::allowed);
    EXPECT_EQ(rules.decide(read_holding(0, 1), "[::ffff:192.0.2.9]:1"), Decision::allowed);
    EXPECT_EQ(rules.decide(read_holding(0, 1), "192.0.3.7:1"), Decision::denied);
    EXPECT_EQ(rules.decide(read_holding(0, 1), "/dev/ttyS0"), Decision::denied);
    rules.rules[0].networks = {};
    rules.rules[0].serial = true;
    EXPECT_EQ(rules.decide(read_holding(0, 1), "/dev/ttyS0"), Decision::allowed);
    EXPECT_EQ(rules.decide(read_holding(0, 1)), Decision::denied);
}

TEST(Access, ReadOnlyRefusesWhatWrites) {
    Rules rules;
    rules.set({{.permission = Permission::read_only}});
    const std::pair<Request, Decision> rows[] = {
        {request({1, 0, 0, 0, 1}), Decision::allowed},
        {request({2, 0, 0, 0, 1}), Decision::allowed},
        {request({3, 0, 0, 0, 1}), Decision::allowed},
        {request({4, 0, 0, 0, 1}), Decision::allowed},
        {request({5, 0, 0, 0xFF, 0}), Decision::read_only},
        {request({6, 0, 0, 0, 1}), Decision::read_only},
        {request({6}), Decision::read_only},
        {request({7}), Decision::allowed},
        {request({8, 0, 0, 1, 2}), Decision::allowed},
        {request({8, 0, 1, 0, 0}), Decision::read_only},
        {request({8, 0, 4, 0, 0}), Decision::read_only},
        {request({8, 0, 10, 0, 0}), Decision::read_only},
        {request({8, 0, 11, 0, 0}), Decision::allowed},
        {request({8, 0, 5, 0, 0}), Decision::read_only},
        {request({8, 0, 21, 0, 4}), Decision::read_only},
        {request({11}), Decision::allowed},
        {request({12}), Decision::allowed},
        {request({15, 0, 0, 0, 1, 1, 1}), Decision::read_only},
        {request({16, 0, 0, 0, 1, 2, 0, 1}), Decision::read_only},
        {request({17}), Decision::allowed},
        {request({20, 7, 6, 0, 1, 0, 0, 0, 1}), Decision::allowed},
        {request({21, 9, 6, 0, 1, 0, 0, 0, 1, 0, 0}), Decision::read_only},
        {request({22, 0, 0, 0, 0, 0, 0}), Decision::read_only},
        {request({23, 0, 0, 0, 1, 0, 0, 0, 1, 2, 0, 1}), Decision::read_only},
        {request({24, 0, 0}), Decision::allowed},
        {request({0x2B, 14, 1, 0}), Decision::allowed},
        {request({0x2B, 13, 1, 0}), Decision::read_only},
        {request({0x2B, 1}), Decision::read_only},
        {request({0x63, 1}), Decision::read_only},
    };
    for (const auto& [bytes, expected] : rows) EXPECT_EQ(rules.decide(bytes), expected) << int{bytes[0]};
}

TEST(Access, EveryItemOfARequestCounts) {
    Rules rules;
    const std::array first{AddressRange{0, 9}};
    const std::array second{AddressRange{10, 19}, AddressRange{30, 39}};
    rules.set({{.area = Area::holding_register, .items = first, .permission = Permission::read_only},
               {.area = Area::holding_register, .items = second, .permission = Permission::allow}});
    EXPECT_EQ(rules.decide(read_holding(0, 20)), Decision::allowed) << "by two rules";
    EXPECT_EQ(rules.decide(read_holding(0, 21)), Decision::denied);
    EXPECT_EQ(rules.decide(read_holding(19, 12)), Decision::denied) << "the hole between 19 and 30";
    EXPECT_EQ(rules.decide(read_holding(30, 10)), Decision::allowed);
    EXPECT_EQ(rules.decide(write_holding(9)), Decision::read_only);
    EXPECT_EQ(rules.decide(write_holding(10)), Decision::allowed);
    EXPECT_EQ(rules.decide(request({4, 0, 0, 0, 1})), Decision::denied) << "another area";
    EXPECT_EQ(rules.decide(request({7})), Decision::denied) << "it has no items";
    // Reads 30..31 and writes 9..10: the write touches what is read only.
    EXPECT_EQ(rules.decide(request({23, 0, 30, 0, 2, 0, 9, 0, 2, 4, 0, 1, 0, 2})), Decision::read_only);
    EXPECT_EQ(rules.decide(request({23, 0, 0, 0, 2, 0, 10, 0, 2, 4, 0, 1, 0, 2})), Decision::allowed);
    EXPECT_EQ(rules.decide(read_holding(65535, 2)), Decision::denied);
}

TEST(Access, ItemsBehindTheLastOneAreTheFirstOnes) {
    Rules rules;
    const std::array denied{AddressRange{0, 0}};
    const std::array last{AddressRange{65535, 65535}};
    rules.set({{.area = Area::holding_register, .items = denied, .permission = Permission::deny},
               {.permission = Permission::allow}});
    EXPECT_EQ(rules.decide(request({16, 255, 255, 0, 2, 4, 0, 1, 0, 2})), Decision::denied);
    EXPECT_EQ(rules.decide(read_holding(65535, 2)), Decision::denied);
    EXPECT_EQ(rules.decide(request({23, 0, 9, 0, 1, 255, 255, 0, 2, 4, 0, 1, 0, 2})), Decision::denied);
    EXPECT_EQ(rules.decide(read_holding(65535, 1)), Decision::allowed);
    EXPECT_EQ(rules.decide(read_holding(1, 65535)), Decision::allowed) << "all but the first";
    EXPECT_EQ(rules.decide(read_holding(2, 65535)), Decision::denied);
    rules.set({{.area = Area::holding_register, .items = last, .permission = Permission::allow}});
    EXPECT_EQ(rules.decide(read_holding(65535, 1)), Decision::allowed);
    EXPECT_EQ(rules.decide(read_holding(65535, 2)), Decision::denied);
}

TEST(Access, AFunctionWhoseItemsOnlyTheDeviceKnowsTouchesAllOfThem) {
    Rules rules;
    const std::array some{AddressRange{5, 5}};
    for (const auto& bytes : {request({65, 0, 0}), request({110}), request({0x2B, 13, 1})}) {
        rules.set({{.area = Area::coil, .items = some, .permission = Permission::deny},
                   {.permission = Permission::allow}});
        EXPECT_EQ(rules.decide(bytes), Decision::denied);
        rules.rules[0].permission = Permission::read_only;
        EXPECT_EQ(rules.decide(bytes), Decision::read_only);
        rules.rules[0].permission = Permission::allow;
        EXPECT_EQ(rules.decide(bytes), Decision::allowed);
        rules.set({{.area = Area::coil, .permission = Permission::allow},
                   {.area = Area::discrete_input, .permission = Permission::allow},
                   {.area = Area::input_register, .permission = Permission::allow}});
        EXPECT_EQ(rules.decide(bytes), Decision::denied) << "an area is missing";
        rules.set({{.permission = Permission::read_only}});
        EXPECT_EQ(rules.decide(bytes), Decision::read_only);
    }
}

TEST(Access, FunctionCode43IsSeveralFunctions) {
    Rules rules;
    const Request identification = request({0x2B, 14, 1, 0});
    const Request other = request({0x2B, 13, 1, 0});
    rules.set({{.functions = functions({3}), .identification = true, .permission = Permission::allow}});
    EXPECT_EQ(rules.decide(identification), Decision::allowed);
    EXPECT_EQ(rules.decide(other), Decision::denied);
    EXPECT_EQ(rules.decide(request({0x2B})), Decision::denied);
    rules.set({{.functions = functions({6}), .other_encapsulated = true, .permission = Permission::deny},
               {.permission = Permission::allow}});
    EXPECT_EQ(rules.decide(identification), Decision::allowed);
    EXPECT_EQ(rules.decide(other), Decision::denied);
    rules.set({{.functions = functions({0x2B}), .permission = Permission::allow}});
    EXPECT_EQ(rules.decide(identification), Decision::allowed) << "the code means all of them";
    EXPECT_EQ(rules.decide(other), Decision::allowed);
}

TEST(Access, ABroadcastIsDecidedForEveryUnit) {
    Rules rules;
    const std::array every{UnitRange{1, 255}};
    const std::array some{UnitRange{7, 9}, UnitRange{20, 20}};
    const auto broadcast = [&] {
        return rules.control.decide({Instant{}, UnitId{0}, false, kPeer, {}}, every,
                                    wire::RequestView(write_holding(0)));
    };
    rules.set({{.units = some, .permission = Permission::deny}, {.permission = Permission::allow}});
    EXPECT_EQ(broadcast(), Decision::denied);
    rules.rules[0].permission = Permission::read_only;
    EXPECT_EQ(broadcast(), Decision::read_only);
    rules.rules[0].permission = Permission::allow;
    EXPECT_EQ(broadcast(), Decision::allowed);
    rules.rules.pop_back();
    rules.set(rules.rules);
    EXPECT_EQ(broadcast(), Decision::denied) << "no rule names unit 1";
    const std::array all{UnitRange{1, 8}, UnitRange{9, 255}};
    rules.set({{.units = all, .permission = Permission::allow}});
    EXPECT_EQ(broadcast(), Decision::allowed);
    const std::array last{UnitRange{255, 255}};
    rules.set({{.units = last, .permission = Permission::deny}, {.permission = Permission::allow}});
    EXPECT_EQ(broadcast(), Decision::denied);
}

TEST(Access, EachRuleThatDecidesAnItemChargesItsRate) {
    Rules rules;
    const std::array low{AddressRange{0, 9}};
    const std::array high{AddressRange{10, 19}};
    rules.set({{.area = Area::holding_register, .items = low, .permission = Permission::allow},
               {.area = Area::holding_register,
                .items = high,
                .permission = Permission::allow,
                .rate = RateLimit{1, 5}}});
    const Request both = request({16, 0, 9, 0, 2, 4, 0, 1, 0, 2});
    int passed = 0;
    for (int i = 0; i < 500; ++i)
        if (rules.decide(both) == Decision::allowed) ++passed;
    EXPECT_EQ(passed, 5);
    EXPECT_EQ(rules.decide(write_holding(9)), Decision::allowed);
    EXPECT_EQ(rules.decide(write_holding(10)), Decision::too_fast);
    rules.set({{.functions = functions({23}),
                .area = Area::holding_register,
                .items = low,
                .permission = Permission::allow,
                .rate = RateLimit{1, 3}},
               {.permission = Permission::allow, .rate = RateLimit{1, 2}}});
    const Request reads_low = request({23, 0, 0, 0, 1, 0, 30, 0, 1, 2, 0, 1});
    EXPECT_EQ(rules.decide(reads_low), Decision::allowed);
    EXPECT_EQ(rules.decide(reads_low), Decision::allowed);
    EXPECT_EQ(rules.decide(reads_low), Decision::too_fast) << "the second rule";
    const Request only_low = request({23, 0, 0, 0, 1, 0, 5, 0, 1, 2, 0, 1});
    EXPECT_EQ(rules.decide(only_low), Decision::allowed) << "a refused request takes no token";
    EXPECT_EQ(rules.decide(only_low), Decision::too_fast);
}

TEST(Access, ABroadcastAndARefusalTakeOneTokenAndNone) {
    Rules rules;
    const std::array every{UnitRange{1, 255}};
    const std::array odd{UnitRange{1, 1}, UnitRange{3, 3}};
    rules.set({{.units = odd, .permission = Permission::allow, .rate = RateLimit{1, 2}},
               {.permission = Permission::read_only, .rate = RateLimit{1, 2}}});
    const Context context{Instant{}, UnitId{0}, true, kPeer, {}};
    EXPECT_EQ(rules.control.decide(context, every, wire::RequestView(write_holding(0))), Decision::read_only);
    for (int i = 0; i < 2; ++i)
        EXPECT_EQ(rules.control.decide(context, every, wire::RequestView(read_holding(0, 1))),
                  Decision::allowed);
    EXPECT_EQ(rules.control.decide(context, every, wire::RequestView(read_holding(0, 1))),
              Decision::too_fast);
    EXPECT_EQ(rules.control.decide_again(context, every, wire::RequestView(read_holding(0, 1))),
              Decision::allowed);
}

TEST(Access, ARateIsThatOfEachPeer) {
    Rules rules;
    rules.set({{.permission = Permission::allow, .rate = RateLimit{10, 3}}});
    const Request read = read_holding(0, 1);
    const Instant t = Instant{} + 5s;
    for (int i = 0; i < 3; ++i) EXPECT_EQ(rules.decide(read, kPeer, 1, t), Decision::allowed);
    EXPECT_EQ(rules.decide(read, kPeer, 1, t), Decision::too_fast);
    EXPECT_EQ(rules.decide(read, "192.0.2.7:50101", 1, t), Decision::too_fast)
        << "another port, the same peer";
    EXPECT_EQ(rules.decide(read, "192.0.2.8:50100", 1, t), Decision::allowed);
    EXPECT_EQ(rules.decide(read, kPeer, 1, t + 99ms), Decision::too_fast);
    EXPECT_EQ(rules.decide(read, kPeer, 1, t + 100ms), Decision::allowed);
    EXPECT_EQ(rules.decide(read, kPeer, 1, t + 100ms), Decision::too_fast);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(rules.decide(read, kPeer, 1, t + 1h), Decision::allowed);
    EXPECT_EQ(rules.decide(read, kPeer, 1, t + 1h), Decision::too_fast);
}

TEST(Access, WhoHasAnIpv6NetworkIsOnePeer) {
    Rules rules;
    rules.set({{.permission = Permission::allow, .rate = RateLimit{1, 1}}});
    EXPECT_EQ(rules.decide(read_holding(0, 1), "[2001:db8::1]:1"), Decision::allowed);
    EXPECT_EQ(rules.decide(read_holding(0, 1), "[2001:db8::2]:1"), Decision::too_fast);
    EXPECT_EQ(rules.decide(read_holding(0, 1), "[2001:db8:0:1::2]:1"), Decision::allowed);
}

TEST(Access, ThePeerThatWasLongestSilentMakesRoom) {
    Rules rules;
    rules.set({{.permission = Permission::allow, .rate = RateLimit{1, 1}}});
    const auto peer = [](int i) { return "192.0.2." + std::to_string(i) + ":1"; };
    for (int i = 0; i < 5; ++i) {  // one more than there are buckets
        EXPECT_EQ(rules.decide(read_holding(0, 1), peer(i), 1, Instant{} + 1ms * i), Decision::allowed);
        EXPECT_EQ(rules.decide(read_holding(0, 1), peer(i), 1, Instant{} + 1ms * i), Decision::too_fast);
    }
    EXPECT_EQ(rules.decide(read_holding(0, 1), peer(4), 1, Instant{} + 9ms), Decision::too_fast);
    EXPECT_EQ(rules.decide(read_holding(0, 1), peer(0), 1, Instant{} + 9ms), Decision::allowed);
}

/// Answers every request with its own bytes.
struct Echo final : Responder {
    [[nodiscard]] bool serves(UnitId unit) const override { return unit == UnitId{1} || unit == UnitId{2}; }
    [[nodiscard]] Answer handle(const Context&, const wire::RequestView& request) override {
        ++asked;
        wire::Pdu same;
        same.assign(request.pdu());
        return Answer::response(same);
    }
    int asked = 0;
};

TEST(Access, RejectsWithAnException) {
    Echo echo;
    Rules rules;
    const std::array every{UnitRange{1, 2}};
    const std::array second{UnitRange{2, 2}};
    rules.set({{.units = second, .permission = Permission::read_only, .rate = RateLimit{1, 2}}});
    const auto ask = [&](int unit, const Request& bytes, bool broadcast = false) {
        const Context context{Instant{}, UnitId{static_cast<std::uint8_t>(unit)}, broadcast, kPeer, {}};
        const wire::RequestView asked(bytes);
        const auto decision = broadcast ? rules.control.decide(context, every, asked)
                                        : rules.control.decide(context, context.unit, asked);
        const auto answer =
            decision == Decision::allowed ? echo.handle(context, asked) : rejection(context, asked, decision);
        return answer.kind == Answer::Kind::response ? Request(answer.pdu.begin(), answer.pdu.end())
                                                     : Request();
    };
    EXPECT_EQ(ask(2, read_holding(0, 1)), read_holding(0, 1));
    EXPECT_EQ(ask(2, write_holding(0)), request({0x86, 1}));
    EXPECT_EQ(ask(1, read_holding(0, 1)), request({0x83, 1}));
    EXPECT_EQ(ask(0, write_holding(0), true), Request()) << "not for every unit";
    EXPECT_EQ(echo.asked, 1);
    EXPECT_EQ(ask(2, read_holding(0, 1)), read_holding(0, 1));
    EXPECT_EQ(ask(2, read_holding(0, 1)), request({0x83, 6}));
    EXPECT_EQ(echo.asked, 2);
}

/// The same decision, item by item.
Decision reference(const std::vector<AccessRule>& rules, const wire::RequestView& request) {
    const auto decided = [&](const AccessRule& rule, bool writes) {
        if (rule.permission == Permission::allow || (rule.permission == Permission::read_only && !writes))
            return Decision::allowed;
        return rule.permission == Permission::deny ? Decision::denied : Decision::read_only;
    };
    const auto function = static_cast<std::uint8_t>(request.function());
    for (const wire::ItemAccess& access : request.accesses()) {
        for (unsigned i = 0; i < access.count; ++i) {
            const unsigned item = (access.start + i) % 65536;
            Decision decision = Decision::denied;
            for (const auto& rule : rules) {
                const bool named =
                    !rule.area ||
                    (*rule.area == access.area &&
                     (rule.items.empty() || std::ranges::any_of(rule.items, [&](const AddressRange& range) {
                          return range.first <= item && item <= range.last;
                      })));
                if (!named || !rule.functions.has(function)) continue;
                decision = decided(rule, access.write);
                break;
            }
            if (decision != Decision::allowed) return Decision::denied;
        }
    }
    return Decision::allowed;
}

RC_GTEST_PROP(Access, DecidesAsItemByItem, ()) {
    const auto small = rc::gen::inRange<unsigned>(0, 40);
    std::vector<std::vector<AddressRange>> items(*rc::gen::inRange<std::size_t>(0, 6));
    std::vector<AccessRule> rules;
    for (auto& ranges : items) {
        unsigned next = *small;
        for (int i = *rc::gen::inRange(0, 4); i > 0; --i) {
            const unsigned last = next + *rc::gen::inRange<unsigned>(0, 8);
            ranges.push_back({static_cast<std::uint16_t>(next), static_cast<std::uint16_t>(last)});
            next = last + 1 + *rc::gen::inRange<unsigned>(0, 5);
        }
        AccessRule rule;
        rule.items = ranges;
        if (!ranges.empty() || *rc::gen::arbitrary<bool>())
            rule.area = *rc::gen::element(Area::holding_register, Area::coil);
        rule.permission =
            *rc::gen::element(Permission::allow, Permission::allow, Permission::read_only, Permission::deny);
        if (*rc::gen::inRange(0, 3) == 0) rule.functions = functions({3, 23, *rc::gen::element(1, 6)});
        rules.push_back(rule);
    }
    Rules under_test;
    under_test.set(rules);
    const int first = static_cast<int>(*small);
    const int count = *rc::gen::inRange(1, 30);
    const int other = static_cast<int>(*small);
    const Request bytes =
        *rc::gen::element(read_holding(first, count), write_holding(first), request({1, 0, first, 0, count}),
                          request({15, 0, first, 0, count, 1, 1}),
                          request({23, 0, first, 0, count, 0, other, 0, count / 2 + 1}));
    if (rules.empty()) return;
    const auto decision = under_test.decide(bytes);
    RC_ASSERT((decision == Decision::allowed) ==
              (reference(rules, wire::RequestView(bytes)) == Decision::allowed));
}

}  // namespace access_test
}  // namespace takt::serve
