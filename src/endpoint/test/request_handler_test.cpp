// The order of the steps of a request: faults, rules, own unit or route, audit.
#include "takt/endpoint/request_handler.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "support.hpp"
#include "takt/endpoint/line_gateway.hpp"
#include "takt/serve/server.hpp"

namespace takt::endpoint {
namespace request_handler_test {

using namespace std::chrono_literals;
using test::pdu;
using test::to_hex;
using Event = AuditRecord::Event;
using Kind = serve::Answer::Kind;

constexpr Instant kNow{1h};

/// Own units 1 and 2 with ten holding registers each; unit 7 is relayed.
struct Bench {
    explicit Bench(std::shared_ptr<sim::AnswerFaults> faults = nullptr)
        : handler(&server, {UnitId{1}, UnitId{2}, UnitId{7}}, std::move(faults)) {
        for (std::size_t i = 0; i < units.size(); ++i) {
            units[i].id = UnitId{static_cast<std::uint8_t>(i + 1)};
            units[i].banks.holding_registers.values = registers[i];
            units[i].hooks = &handler.audit().watch(units[i]);
        }
        server = serve::Server(units);
        gateway.on_link(true);
        handler.set_routes(serve::RouteTable(0, {{&gateway, {}, {}}}, {{UnitId{7}, UnitId{17}, 0}}));
        handler.pending().add(answers);
    }

    /// The answer; "pending" and "" where there is none.
    std::string ask(int unit, std::string_view request, bool broadcast = false) {
        const serve::Context context{
            kNow, UnitId{static_cast<std::uint8_t>(unit)}, broadcast, "192.0.2.1:5", {}};
        const auto answer = handler.handle(context, wire::RequestView(pdu(request).span()));
        token = answer.token;
        delay = answer.delay;
        if (answer.kind == Kind::pending) return "pending";
        return answer.kind == Kind::silence ? "" : to_hex(answer.pdu.span());
    }
    void record() { handler.audit().set_sink(records); }
    void deliver() {
        while (const auto reply = gateway.take_reply()) handler.on_relayed(*reply);
    }
    /// The gateway's transaction ends. @param answer  of the device; empty: none came
    void end(std::string_view answer, bus::Status status = bus::Status::ok, bool sent = true) {
        const auto begun = gateway.next(kNow);
        ASSERT_TRUE(begun);
        const auto bytes = pdu(answer);
        bus::Outcome outcome{.id = begun->id, .unit = begun->unit, .status = status, .sent = sent};
        if (!bytes.empty()) outcome.response = wire::ResponseView(bytes.span());
        if (bytes.size() == 2) outcome.status = bus::Status::exception;
        gateway.on_outcome(outcome);
        deliver();
    }
    /// Unit 7 is unit 17 of the line, unit 8 all its units, and unit 0 too if `all`.
    void route_broadcasts(bool all) {
        std::vector<serve::Route> routes{{UnitId{7}, UnitId{17}, 0}, {UnitId{8}, UnitId{0}, 0}};
        if (all) routes.push_back({UnitId{0}, UnitId{0}, 0});
        handler.set_routes(serve::RouteTable(0, {{&gateway, {}, {}, {}}}, routes));
    }
    /// The audit log: "write 1", "refused 7 rule 1"; of a relayed write "write 7 done at 17"; where the own
    /// unit is another one "write 255 by 1".
    [[nodiscard]] std::vector<std::string> log() const {
        std::vector<std::string> all;
        for (const auto& record : records->all) {
            std::string line =
                (record.event == Event::write ? "write " : "refused ") + std::to_string(record.unit);
            if (record.event == Event::refused)
                line += " " + std::string(record.why) + " " + std::to_string(record.exception);
            if (record.outcome != AuditRecord::Outcome::none) line += " " + std::string(name(record.outcome));
            if (record.broadcast) line += " to all";
            if (record.own_unit) line += " by " + std::to_string(*record.own_unit);
            if (record.relayed_to) line += " at " + std::to_string(*record.relayed_to);
            all.push_back(line);
        }
        return all;
    }

    std::array<std::array<std::uint16_t, 10>, 2> registers{};
    std::array<serve::Unit, 2> units;
    serve::Server server{{}};
    serve::Gateway gateway;
    test::Answers answers;
    std::shared_ptr<test::Records> records = std::make_shared<test::Records>();
    RequestHandler handler;
    serve::Token token = 0;
    Duration delay{};
};

std::shared_ptr<sim::AnswerFaults> faults(std::string_view rule) {
    auto made = std::make_shared<sim::AnswerFaults>();
    made->add(kNow, *sim::parse_fault(rule));
    return made;
}

model::AccessRule deny_writes() {
    model::AccessRule rule;
    rule.permission = model::AccessPermission::read_only;
    return rule;
}

/// The response as the engine hands it on; `pdu` outlives it.
wire::ResponseView response_to(const bus::Transaction& sent, const wire::Pdu& pdu) {
    const auto view = wire::decode_response(sent.request.shape(), sent.request.pdu(), pdu.span());
    EXPECT_TRUE(view);
    return view.value_or(wire::ResponseView());
}

TEST(RequestHandler, AnOwnUnitGoesBeforeARoute) {
    Bench bench;
    bench.handler.set_routes(serve::RouteTable(0, {{&bench.gateway, {}, {}}},
                                               {{UnitId{1}, UnitId{9}, 0}, {UnitId{7}, UnitId{17}, 0}}));
    EXPECT_EQ(bench.ask(1, "06 00 00 00 05"), "06 00 00 00 05");
    EXPECT_EQ(bench.registers[0][0], 5);
    EXPECT_EQ(bench.ask(255, "03 00 00 00 01"), "03 02 00 05") << "the first own unit";
    EXPECT_EQ(bench.ask(0, "03 00 00 00 01"), "03 02 00 05");
    EXPECT_EQ(bench.ask(7, "03 00 00 00 01"), "pending");
    EXPECT_EQ(bench.ask(8, "03 00 00 00 01"), "83 0A");
    EXPECT_TRUE(bench.handler.serves(UnitId{7}));
    EXPECT_FALSE(bench.handler.serves(UnitId{8}));
}

TEST(RequestHandler, WithoutOwnUnitsOnlyRoutesAnswer) {
    RequestHandler handler(nullptr, {}, nullptr);
    const auto answer =
        handler.handle({kNow, UnitId{1}, false, "", {}}, wire::RequestView(pdu("03 00 00 00 01").span()));
    EXPECT_EQ(to_hex(answer.pdu.span()), "83 0A");
}

TEST(RequestHandler, ARelayedAnswerComesByItsToken) {
    Bench bench;
    EXPECT_EQ(bench.ask(7, "03 00 00 00 01"), "pending");
    const auto sent = bench.gateway.next(kNow);
    ASSERT_TRUE(sent);
    EXPECT_EQ(sent->unit, UnitId{17});
    const auto response = pdu("03 02 00 2A");
    bench.gateway.on_outcome({.id = sent->id, .response = response_to(*sent, response)});
    bench.deliver();
    EXPECT_EQ(bench.answers.of(bench.token), "03 02 00 2A");
    bench.gateway.on_link(false);
    EXPECT_EQ(bench.ask(7, "03 00 00 00 01"), "83 0A") << "at once, and nothing is pending";
    EXPECT_EQ(bench.handler.pending().size(), 0u);
}

TEST(RequestHandler, ABroadcastGoesToAllOwnUnitsAndAlongTheRouteOfUnit0) {
    Bench bench;
    EXPECT_EQ(bench.ask(0, "06 00 00 00 05", true), "");
    EXPECT_EQ(bench.registers[0][0], 5);
    EXPECT_EQ(bench.registers[1][0], 5);
    EXPECT_FALSE(bench.gateway.has_next());
    bench.handler.set_routes(serve::RouteTable(0, {{&bench.gateway, {}, {}}}, {{UnitId{0}, UnitId{0}, 0}}));
    EXPECT_EQ(bench.ask(0, "06 00 00 00 06", true), "");
    EXPECT_EQ(bench.registers[0][0], 6);
    EXPECT_TRUE(bench.gateway.has_next());
    EXPECT_EQ(bench.handler.pending().size(), 0u) << "it is not answered";
}

model::AccessRule rule_for(model::AccessPermission permission, int first, int last) {
    model::AccessRule rule;
    rule.permission = permission;
    rule.units = {{static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(last)}};
    return rule;
}

model::AccessRule allow() {
    model::AccessRule rule;
    rule.permission = model::AccessPermission::allow;
    return rule;
}

TEST(RequestHandler, Units0And255AreDecidedAsTheFirstUnit) {
    Bench bench;
    bench.handler.set_access({rule_for(model::AccessPermission::deny, 1, 1), allow()});
    EXPECT_EQ(bench.ask(0, "03 00 00 00 01"), "83 01");
    EXPECT_EQ(bench.ask(255, "03 00 00 00 01"), "83 01");
    EXPECT_EQ(bench.ask(2, "03 00 00 00 01"), "03 02 00 00");
    bench.handler.set_access({rule_for(model::AccessPermission::allow, 1, 1)});
    EXPECT_EQ(bench.ask(255, "03 00 00 00 01"), "03 02 00 00");
}

TEST(RequestHandler, RulesSeeTheUnitOnTheLine) {
    Bench bench;
    bench.handler.set_access({rule_for(model::AccessPermission::deny, 17, 17), allow()});
    EXPECT_EQ(bench.ask(7, "06 00 00 00 05"), "86 01") << "unit 7 is unit 17 of the line";
    EXPECT_FALSE(bench.gateway.has_next());
    bench.handler.set_access({rule_for(model::AccessPermission::allow, 17, 17)});
    EXPECT_EQ(bench.ask(7, "06 00 00 00 05"), "pending");
}

TEST(RequestHandler, ARelayedBroadcastIsARequestToEveryUnitOfTheLine) {
    Bench bench;
    bench.route_broadcasts(true);
    for (const int denied : {1, 17, 42, 255}) {
        bench.handler.set_access({rule_for(model::AccessPermission::deny, denied, denied), allow()});
        EXPECT_EQ(bench.ask(0, "06 00 00 00 05"), "86 01") << denied;
        EXPECT_EQ(bench.ask(8, "06 00 00 00 05"), "86 01") << denied;
        EXPECT_EQ(bench.ask(0, "06 00 00 00 05", true), "") << denied;
    }
    EXPECT_FALSE(bench.gateway.has_next());
    EXPECT_EQ(bench.registers[0][0], 0) << "also not to own units";
    bench.handler.set_access({rule_for(model::AccessPermission::allow, 1, 255)});
    EXPECT_EQ(bench.ask(0, "06 00 00 00 05"), "pending");
    EXPECT_EQ(bench.ask(8, "06 00 00 00 05"), "pending");
}

TEST(RequestHandler, ABroadcastThatNoLineGetsIsOfTheOwnUnits) {
    Bench bench;
    bench.handler.set_access({rule_for(model::AccessPermission::allow, 1, 2)});
    EXPECT_EQ(bench.ask(0, "06 00 00 00 05", true), "");
    EXPECT_EQ(bench.registers[1][0], 5) << "relayed units do not count";
}

TEST(RequestHandler, ADeniedClientGetsNoSharedAndNoCachedAnswer) {
    Bench bench;
    serve::RequestPolicy policy;
    policy.cache = 1min;
    bench.handler.set_routes(
        serve::RouteTable(0, {{&bench.gateway, policy, {}, {}}}, {{UnitId{7}, UnitId{17}, 0}}));
    auto only_one = allow();
    only_one.every_peer = false;
    only_one.networks = {*parse_network("192.0.2.1")};
    bench.handler.set_access({only_one});
    const auto ask_as = [&](std::string_view peer) {
        const auto answer = bench.handler.handle({kNow, UnitId{7}, false, peer, {}},
                                                 wire::RequestView(pdu("03 00 00 00 01").span()));
        return answer.kind == Kind::pending ? "pending" : to_hex(answer.pdu.span());
    };
    EXPECT_EQ(ask_as("192.0.2.1:5"), "pending");
    EXPECT_EQ(ask_as("192.0.2.2:5"), "83 01") << "while it waits";
    const auto sent = bench.gateway.next(kNow);
    EXPECT_EQ(ask_as("192.0.2.2:5"), "83 01") << "while it is in flight";
    const auto response = pdu("03 02 00 2A");
    bench.gateway.on_outcome(
        {.id = sent->id, .sent = true, .response = response_to(*sent, response), .sent_at = kNow});
    bench.deliver();
    EXPECT_EQ(ask_as("192.0.2.1:6"), "03 02 00 2A") << "from the cache";
    EXPECT_EQ(ask_as("192.0.2.2:5"), "83 01");
    EXPECT_EQ(bench.answers.given.size(), 1u);
}

TEST(RequestHandler, WhatWaitsKeepsTheRoleOfItsClient) {
    Bench bench;
    auto operators = allow();
    operators.roles = {"Operator"};
    bench.handler.set_access({operators});
    const auto bytes = pdu("06 00 00 00 05");
    const serve::Context context{kNow, UnitId{7}, false, "192.0.2.1:5", "Operator"};
    EXPECT_EQ(bench.handler.handle(context, wire::RequestView(bytes.span())).kind, Kind::pending);
    bench.handler.set_access({operators});
    EXPECT_TRUE(bench.gateway.has_next()) << "the same rules allow it";
    operators.permission = model::AccessPermission::deny;
    bench.handler.set_access({operators, allow()});
    EXPECT_FALSE(bench.gateway.has_next());
}

TEST(RequestHandler, RulesThatChangeDecideAgainWhatWaits) {
    Bench bench;
    bench.record();
    EXPECT_EQ(bench.ask(7, "06 00 00 00 05"), "pending");
    const auto in_flight = bench.token;
    const auto sent = bench.gateway.next(kNow);
    EXPECT_EQ(bench.ask(7, "06 00 01 00 05"), "pending");
    const auto waits = bench.token;
    EXPECT_EQ(bench.ask(7, "03 00 00 00 01"), "pending");
    const auto read = bench.token;
    bench.handler.set_access({deny_writes()});
    bench.deliver();
    EXPECT_EQ(bench.answers.of(waits), "86 01");
    EXPECT_EQ(bench.answers.of(in_flight), "") << "it was sent";
    EXPECT_EQ(bench.log(), std::vector<std::string>{"refused 7 read_only 1 not_sent at 17"});
    const auto response = pdu("06 00 00 00 05");
    bench.gateway.on_outcome({.id = sent->id, .sent = true, .response = response_to(*sent, response)});
    bench.deliver();
    EXPECT_EQ(bench.answers.of(in_flight), "06 00 00 00 05");
    bench.end("03 02 00 07");
    EXPECT_EQ(bench.answers.of(read), "03 02 00 07") << "it is still allowed";
    EXPECT_EQ(bench.log().back(), "write 7 done at 17");
}

TEST(RequestHandler, AReadThatChangedRulesRefuseIsRecorded) {
    Bench bench;
    bench.record();
    EXPECT_EQ(bench.ask(7, "03 00 00 00 01"), "pending");
    EXPECT_TRUE(bench.gateway.next(kNow));
    EXPECT_EQ(bench.ask(7, "03 00 05 00 01"), "pending");
    const auto waits = bench.token;
    bench.handler.set_access({rule_for(model::AccessPermission::deny, 17, 17), allow()});
    bench.deliver();
    EXPECT_EQ(bench.answers.of(waits), "83 01");
    EXPECT_EQ(bench.log(), std::vector<std::string>{"refused 7 rule 1 at 17"});
}

TEST(RequestHandler, WhatTheLineDidNotSendYetIsTakenBack) {
    Bench bench;
    test::FakeLine line;
    line.sent = false;
    LineGateway gateway({}, line,
                        [&](const serve::Gateway::Reply& reply) { bench.handler.on_relayed(reply); });
    gateway.work(kNow);
    bench.handler.set_routes(serve::RouteTable(0, {{&gateway.gateway(), {}, {}, [&] { gateway.withdraw(); }}},
                                               {{UnitId{7}, UnitId{17}, 0}}));
    const auto work = [&] { gateway.work(kNow); };
    bench.record();
    EXPECT_EQ(bench.ask(7, "06 00 00 00 05"), "pending");
    const auto first = bench.token;
    work();
    ASSERT_TRUE(line.flight);
    bench.handler.set_access({deny_writes()});
    work();
    EXPECT_FALSE(line.flight);
    EXPECT_EQ(bench.answers.of(first), "86 01");
    bench.handler.set_access({});
    EXPECT_EQ(bench.ask(7, "06 00 00 00 06"), "pending");
    work();
    ASSERT_TRUE(line.flight);
    bench.handler.forget(bench.token);
    EXPECT_FALSE(line.flight);
    EXPECT_EQ(bench.log(), (std::vector<std::string>{"refused 7 read_only 1 not_sent at 17",
                                                     "refused 7 disconnected 0 not_sent at 17"}));
    EXPECT_EQ(bench.ask(7, "06 00 00 00 07"), "pending");
    work();
    line.sent = true;
    bench.handler.set_access({deny_writes()});
    ASSERT_TRUE(line.flight) << "it is on the wire";
    bench.handler.forget(bench.token);
    EXPECT_EQ(bench.log().back(), "write 7 unknown at 17");
}

TEST(RequestHandler, RulesComeBeforeTheUnit) {
    Bench bench;
    bench.handler.set_access({deny_writes()});
    EXPECT_EQ(bench.ask(1, "06 00 00 00 05"), "86 01");
    EXPECT_EQ(bench.registers[0][0], 0);
    EXPECT_EQ(bench.ask(7, "06 00 00 00 05"), "86 01") << "relayed units too";
    EXPECT_FALSE(bench.gateway.has_next());
    EXPECT_EQ(bench.ask(0, "06 00 00 00 05", true), "") << "a broadcast is never answered";
    EXPECT_EQ(bench.registers[0][0], 0);
    EXPECT_EQ(bench.ask(1, "03 00 00 00 01"), "03 02 00 00");
    bench.handler.set_access({});
    EXPECT_EQ(bench.ask(1, "06 00 00 00 05"), "06 00 00 00 05");
}

TEST(RequestHandler, FaultsComeBeforeTheRules) {
    Bench bench(faults("exception=6"));
    bench.handler.set_access({deny_writes()});
    bench.record();
    EXPECT_EQ(bench.ask(1, "06 00 00 00 05"), "86 06");
    EXPECT_TRUE(bench.log().empty()) << "the request was never looked at";
    Bench silent(faults("silence"));
    EXPECT_EQ(silent.ask(1, "06 00 00 00 05"), "");
    EXPECT_EQ(silent.registers[0][0], 5) << "it was done";
    Bench late(faults("delay=20ms"));
    EXPECT_EQ(late.ask(1, "03 00 00 00 01"), "03 02 00 00");
    EXPECT_EQ(late.delay, Duration(20ms));
}

TEST(RequestHandler, AuditRecordsWritesAndRefusals) {
    Bench bench;
    bench.registers[0][0] = 3;
    bench.record();
    (void)bench.ask(1, "03 00 00 00 01");
    (void)bench.ask(1, "06 00 00 00 05");
    (void)bench.ask(1, "06 00 64 00 05");
    (void)bench.ask(255, "06 00 01 00 07");
    EXPECT_EQ(bench.log(), (std::vector<std::string>{"write 1", "refused 1 exception 2", "write 255 by 1"}));
    const auto& write = bench.records->all[0];
    EXPECT_EQ(to_hex(write.old_values.span()), "00 03");
    EXPECT_EQ(to_hex(write.new_values.span()), "00 05");
    EXPECT_EQ(write.peer.view(), "192.0.2.1:5");
    bench.handler.set_access({deny_writes()});
    (void)bench.ask(1, "06 00 00 00 05");
    EXPECT_EQ(bench.log().back(), "refused 1 read_only 1");
    EXPECT_EQ(to_hex(bench.records->all.back().request.span()), "06 00 00 00 05");
}

TEST(RequestHandler, ABroadcastIsRecordedOnceForEachUnit) {
    Bench bench;
    bench.record();
    (void)bench.ask(0, "06 00 00 00 05", true);
    EXPECT_EQ(bench.log(), (std::vector<std::string>{"write 0 to all by 1", "write 0 to all by 2"}));
    EXPECT_TRUE(bench.records->all[0].broadcast);
}

TEST(RequestHandler, ABroadcastIsRecordedAsEachUnitTookIt) {
    Bench bench;
    bench.units[1].banks.holding_registers.values = std::span(bench.registers[1]).first(5);
    bench.record();
    for (const auto* const request :
         {"06 00 07 00 05", "41 01", "15 09 06 00 01 00 00 00 01 AA BB", "08 00 01 00 00", "2B 0D 01",
          "17 00 00 00 01 00 00 00 01 02 00 AA", "10 00 00 00 01 02 00"})
        EXPECT_EQ(bench.ask(0, request, true), "");
    (void)bench.ask(0, "03 00 00 00 01", true);
    std::vector<std::string> expected{"write 0 to all by 1", "refused 0 exception 2 to all by 2"};
    for (const char exception : {'1', '1', '1', '1', '1', '3'})
        for (const char unit : {'1', '2'})
            expected.push_back(std::string("refused 0 exception ") + exception + " to all by " + unit);
    EXPECT_EQ(bench.log(), expected) << "a read is not recorded";
    EXPECT_EQ(bench.registers[1][7], 0);
}

TEST(RequestHandler, AnAuditRecordNamesTheUnitOfTheRequestAndTheOwnOne) {
    Bench bench;
    bench.record();
    (void)bench.ask(0, "06 00 01 00 07");
    (void)bench.ask(255, "06 00 64 00 05");
    (void)bench.ask(0, "41 01");
    (void)bench.ask(2, "06 00 01 00 07");
    (void)bench.ask(9, "06 00 01 00 07");
    EXPECT_EQ(bench.log(),
              (std::vector<std::string>{"write 0 by 1", "refused 255 exception 2 by 1",
                                        "refused 0 exception 1 by 1", "write 2", "refused 9 exception 10"}));
}

TEST(RequestHandler, ARequestThatAUnitIgnoresIsNotRecorded) {
    Bench bench;
    struct ListenOnly final : serve::Extension {
        bool handle(serve::Unit&, const serve::Context&, const wire::RequestView&, serve::Answer&) override {
            return false;
        }
        bool admit(const serve::Context&, const wire::RequestView&) override { return false; }
    } listen_only;
    const std::array<serve::Extension*, 1> extensions{&listen_only};
    bench.units[0].extensions = extensions;
    bench.record();
    for (const auto* const request : {"06 00 00 00 05", "41 01"}) EXPECT_EQ(bench.ask(1, request), "");
    EXPECT_TRUE(bench.log().empty());
    EXPECT_EQ(bench.ask(0, "06 00 00 00 05", true), "");
    EXPECT_EQ(bench.log(), std::vector<std::string>{"write 0 to all by 2"});
}

TEST(RequestHandler, ARelayedWriteIsRecordedWhenItIsAnswered) {
    struct Row {
        const char* answer;
        const char* logged;
    };
    for (const auto& [answer, logged] :
         {Row{"06 00 00 00 05", "write 7 done at 17"}, Row{"86 02", "refused 7 exception 2 refused at 17"},
          Row{"86 05", "write 7 unknown at 17"}, Row{"86 0B", "write 7 unknown at 17"}}) {
        Bench bench;
        bench.record();
        EXPECT_EQ(bench.ask(7, "06 00 00 00 05"), "pending");
        EXPECT_TRUE(bench.log().empty());
        const auto sent = bench.gateway.next(kNow);
        const auto response = pdu(answer);
        bench.gateway.on_outcome({.id = sent->id,
                                  .status = response.size() == 2 ? bus::Status::exception : bus::Status::ok,
                                  .response = response_to(*sent, response)});
        bench.deliver();
        EXPECT_EQ(bench.log(), std::vector<std::string>{logged});
    }
}

TEST(RequestHandler, AWriteWhoseClientGoesWasNotSentOrMayHaveBeenDone) {
    Bench bench;
    bench.record();
    (void)bench.ask(7, "06 00 00 00 05");
    bench.handler.forget(bench.token);
    EXPECT_EQ(bench.log(), std::vector<std::string>{"refused 7 disconnected 0 not_sent at 17"});
    EXPECT_FALSE(bench.gateway.has_next()) << "it is not sent any more";
    (void)bench.ask(7, "06 00 00 00 05");
    (void)bench.gateway.next(kNow);
    bench.handler.forget(bench.token);
    EXPECT_EQ(bench.log().back(), "write 7 unknown at 17");
    bench.handler.audit().set_sink(nullptr);
    EXPECT_EQ(bench.log().size(), 2u);
}

TEST(RequestHandler, TheEndOfTheEndpointRecordsWhatItWaitsFor) {
    Bench bench;
    bench.route_broadcasts(true);
    bench.record();
    (void)bench.ask(7, "06 00 00 00 05");
    (void)bench.gateway.next(kNow);
    (void)bench.ask(0, "06 00 00 00 05", true);
    bench.handler.forget_relayed();
    auto log = bench.log();
    std::ranges::sort(log);
    EXPECT_EQ(
        log, (std::vector<std::string>{"refused 0 disconnected 0 not_sent to all at 0", "write 0 to all by 1",
                                       "write 0 to all by 2", "write 7 unknown at 17"}));
    EXPECT_EQ(bench.handler.pending().size(), 0u);
}

TEST(RequestHandler, ARelayedWriteThatIsNotSentSaysSo) {
    Bench bench;
    bench.record();
    EXPECT_EQ(bench.ask(7, "06 00 00 00 05 00"), "86 03");
    (void)bench.ask(7, "06 00 00 00 05");
    bench.end("", bus::Status::line_busy, false);
    (void)bench.ask(7, "06 00 00 00 05");
    bench.gateway.on_tick(kNow + 1h);
    bench.deliver();
    (void)bench.ask(7, "06 00 00 00 05");
    bench.gateway.on_link(false);
    bench.deliver();
    EXPECT_EQ(bench.ask(7, "06 00 00 00 05"), "86 0A");
    bench.gateway.on_link(true);
    (void)bench.ask(7, "06 00 00 00 05");
    bench.end("", bus::Status::timeout);
    (void)bench.ask(7, "06 00 00 00 05");
    bench.end("", bus::Status::link_lost);
    (void)bench.ask(7, "41 01");
    bench.end("41");
    EXPECT_EQ(bench.log(),
              (std::vector<std::string>{
                  "refused 7 exception 3 not_sent at 17", "refused 7 exception 10 not_sent at 17",
                  "refused 7 exception 6 not_sent at 17", "refused 7 exception 10 not_sent at 17",
                  "refused 7 exception 10 not_sent at 17", "write 7 unknown at 17", "write 7 unknown at 17",
                  "write 7 done at 17"}));
}

TEST(RequestHandler, ARelayedBroadcastIsMarked) {
    Bench bench;
    bench.route_broadcasts(true);
    bench.record();
    EXPECT_EQ(bench.ask(0, "06 00 00 00 05"), "pending") << "over TCP it is answered";
    bench.end("");
    EXPECT_EQ(bench.ask(8, "06 00 00 00 05"), "pending");
    bench.end("");
    EXPECT_EQ(bench.ask(0, "06 00 00 00 06", true), "");
    bench.end("");
    EXPECT_EQ(bench.log(), (std::vector<std::string>{"write 0 sent to all at 0", "write 8 sent to all at 0",
                                                     "write 0 to all by 1", "write 0 to all by 2",
                                                     "write 0 sent to all at 0"}));
}

TEST(RequestHandler, ItemsBehindTheLastOneAreCounted) {
    Bench bench;
    bench.record();
    (void)bench.ask(7, "10 FF FF 00 02 04 00 01 00 02");
    bench.end("10 FF FF 00 02");
    ASSERT_EQ(bench.records->all.size(), 1u);
    EXPECT_EQ(bench.records->all[0].items->start, 65535);
    EXPECT_EQ(bench.records->all[0].items->count, 2);
}

TEST(RequestHandler, ALateRefusalOfAnOwnUnitIsRecordedToo) {
    Bench bench;
    bench.record();
    struct Slow final : serve::UnitHooks {
        std::optional<wire::ExceptionCode> before(const serve::Context&, const serve::Access&) override {
            return std::nullopt;
        }
        void written(const serve::Context& context, const serve::Access& access) override {
            (void)pending->put_off();
            audit->written(context, access);
        }
        PendingAnswers* pending = nullptr;
        serve::UnitHooks* audit = nullptr;
    } slow;
    slow.pending = &bench.handler.pending();
    slow.audit = bench.units[0].hooks;
    bench.units[0].hooks = &slow;
    EXPECT_EQ(bench.ask(1, "06 00 00 00 05"), "pending");
    EXPECT_EQ(bench.log(), std::vector<std::string>{"write 1"});
    bench.handler.pending().done(bench.token, wire::ExceptionCode::server_device_failure);
    EXPECT_EQ(bench.log(), (std::vector<std::string>{"write 1", "refused 1 exception 4"}));
    EXPECT_EQ(bench.answers.of(bench.token), "86 04");
}

}  // namespace request_handler_test
}  // namespace takt::endpoint
