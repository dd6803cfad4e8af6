// The order of the steps of a request: faults, rules, own unit or route, audit.
#include "takt/endpoint/request_handler.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "support.hpp"
#include "takt/serve/server.hpp"

namespace takt::endpoint {
namespace {

using namespace std::chrono_literals;
using test::hex;
using test::pdu;
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
        handler.set_routes(relay::RelayRoutes(0, {{&gateway, {}, {}}}, {{UnitId{7}, UnitId{17}, 0}}));
        handler.pending().add(answers);
    }

    /// The answer; "pending" and "" where there is none.
    std::string ask(int unit, std::string_view request, bool broadcast = false) {
        const serve::Context context{
            kNow, UnitId{static_cast<std::uint8_t>(unit)}, broadcast, "192.0.2.1:5", {}};
        const auto answer = handler.handle(context, pdu(request).span());
        token = answer.token;
        delay = answer.delay;
        if (answer.kind == Kind::pending) return "pending";
        return answer.kind == Kind::silence ? "" : hex(answer.pdu.span());
    }
    void record() { handler.audit().set_sink(records); }
    void deliver() {
        while (const auto reply = gateway.take_reply())
            handler.pending().complete(reply->token, reply->pdu.span());
    }
    /// The audit log: "write 1", "refused 7 rule 1".
    [[nodiscard]] std::vector<std::string> log() const {
        std::vector<std::string> all;
        for (const auto& record : records->all) {
            std::string line =
                (record.event == Event::write ? "write " : "refused ") + std::to_string(record.unit);
            if (record.event == Event::refused)
                line += " " + std::string(record.why) + " " + std::to_string(record.exception);
            all.push_back(line);
        }
        return all;
    }

    std::array<std::array<std::uint16_t, 10>, 2> registers{};
    std::array<serve::Unit, 2> units;
    serve::Server server{{}};
    relay::Gateway gateway;
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
    bench.handler.set_routes(relay::RelayRoutes(0, {{&bench.gateway, {}, {}}},
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
    const auto answer = handler.handle({kNow, UnitId{1}, false, "", {}}, pdu("03 00 00 00 01").span());
    EXPECT_EQ(hex(answer.pdu.span()), "83 0A");
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
    bench.handler.set_routes(relay::RelayRoutes(0, {{&bench.gateway, {}, {}}}, {{UnitId{0}, UnitId{0}, 0}}));
    EXPECT_EQ(bench.ask(0, "06 00 00 00 06", true), "");
    EXPECT_EQ(bench.registers[0][0], 6);
    EXPECT_TRUE(bench.gateway.has_next());
    EXPECT_EQ(bench.handler.pending().size(), 0u) << "it is not answered";
}

TEST(RequestHandler, RulesComeBeforeTheUnit) {
    Bench bench;
    bench.handler.access().set({deny_writes()});
    EXPECT_EQ(bench.ask(1, "06 00 00 00 05"), "86 01");
    EXPECT_EQ(bench.registers[0][0], 0);
    EXPECT_EQ(bench.ask(7, "06 00 00 00 05"), "86 01") << "relayed units too";
    EXPECT_FALSE(bench.gateway.has_next());
    EXPECT_EQ(bench.ask(0, "06 00 00 00 05", true), "") << "a broadcast is never answered";
    EXPECT_EQ(bench.registers[0][0], 0);
    EXPECT_EQ(bench.ask(1, "03 00 00 00 01"), "03 02 00 00");
    bench.handler.access().set({});
    EXPECT_EQ(bench.ask(1, "06 00 00 00 05"), "06 00 00 00 05");
}

TEST(RequestHandler, FaultsComeBeforeTheRules) {
    Bench bench(faults("exception=6"));
    bench.handler.access().set({deny_writes()});
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
    EXPECT_EQ(bench.log(), (std::vector<std::string>{"write 1", "refused 1 exception 2", "write 1"}));
    const auto& write = bench.records->all[0];
    EXPECT_EQ(hex(write.old_values.span()), "00 03");
    EXPECT_EQ(hex(write.new_values.span()), "00 05");
    EXPECT_EQ(write.peer.view(), "192.0.2.1:5");
    bench.handler.access().set({deny_writes()});
    (void)bench.ask(1, "06 00 00 00 05");
    EXPECT_EQ(bench.log().back(), "refused 1 read_only 1");
    EXPECT_EQ(hex(bench.records->all.back().request.span()), "06 00 00 00 05");
}

TEST(RequestHandler, ABroadcastIsRecordedOnceForEachUnit) {
    Bench bench;
    bench.record();
    (void)bench.ask(0, "06 00 00 00 05", true);
    EXPECT_EQ(bench.log(), (std::vector<std::string>{"write 1", "write 2"}));
    EXPECT_TRUE(bench.records->all[0].broadcast);
}

TEST(RequestHandler, ARelayedWriteIsRecordedWhenItIsAnswered) {
    struct Row {
        const char* answer;
        const char* logged;
    };
    for (const auto& [answer, logged] :
         {Row{"06 00 00 00 05", "write 7"}, Row{"86 02", "refused 7 exception 2"}}) {
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

TEST(RequestHandler, AWriteWhoseClientGoesMayHaveBeenDone) {
    Bench bench;
    bench.record();
    (void)bench.ask(7, "06 00 00 00 05");
    bench.handler.forget(bench.token);
    EXPECT_EQ(bench.log(), std::vector<std::string>{"write 7"});
    EXPECT_FALSE(bench.gateway.has_next()) << "it is not sent any more";
    (void)bench.ask(7, "06 00 00 00 05");
    bench.handler.audit().set_sink(nullptr);
    EXPECT_EQ(bench.log().size(), 2u) << "also when the log ends";
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

}  // namespace
}  // namespace takt::endpoint
