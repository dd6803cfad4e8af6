// Whole endpoints, asked without a port: units, hooks, bindings, retained registers and relays together.
#include "takt/endpoint/endpoint_set.hpp"

#include <gtest/gtest.h>

#include "folder.hpp"
#include "support.hpp"
#include "takt/endpoint/local_values.hpp"

namespace takt::endpoint {
namespace endpoint_test {

using test::pdu;
using test::to_hex;

constexpr Duration kDeadline = std::chrono::seconds(30);  // of what happens at once

/// The servers of a project, without their listeners. The project's lines are played by the test.
struct Bench {
    Bench(const std::string& yaml, std::string in)
        : folder(std::move(in)), plant(test::project(yaml)), values(plant) {
        Environment environment{*loop, notices.sink()};
        environment.audit = [this](Instant, const AuditRecord& record) {
            audited.push_back(audit_line(record));
        };
        environment.served = served(plant, values);
        set.emplace(specs(plant), environment);
    }
    ServedProject served(const model::Project& project, LocalValues& locals) {
        return {&project, &locals, [this](std::size_t index) -> SharedLine& {
                    relayed.push_back(index);
                    return line;
                }};
    }
    [[nodiscard]] std::vector<EndpointSpec> specs(const model::Project& project) const {
        auto all = server_endpoints(project, folder + "/plant.yaml", {}, true);
        for (auto& spec : all) spec.listeners.clear();
        return all;
    }
    /// Another project takes the place of `plant`.
    Result<void> apply(const std::string& yaml) {
        next = std::make_unique<model::Project>(test::project(yaml));
        next_values = std::make_unique<LocalValues>(*next);
        set->leave(*next);
        return set->enter(specs(*next), served(*next, *next_values));
    }
    std::string ask(std::size_t endpoint, int unit, std::string_view request) {
        const serve::Context context{
            line::now(), UnitId{static_cast<std::uint8_t>(unit)}, false, "192.0.2.1:5", {}};
        const auto answer =
            (*set)[endpoint].handler().handle(context, wire::RequestView(pdu(request).span()));
        token = answer.token;
        return answer.kind == serve::Answer::Kind::pending ? "pending" : to_hex(answer.pdu.span());
    }

    std::unique_ptr<line::Loop> loop = line::Loop::create().value();
    std::string folder;
    model::Project plant;
    LocalValues values;
    std::unique_ptr<model::Project> next;
    std::unique_ptr<LocalValues> next_values;
    test::Notices notices;
    test::FakeLine line;
    std::vector<std::size_t> relayed;
    std::vector<std::string> audited;  // by the observer
    std::optional<EndpointSet> set;
    serve::Token token = 0;
};

class EndpointTest : public testing::Test {
protected:
    [[nodiscard]] std::string audit() const { return folder_.read("audit.log"); }

    const takt::test::Folder folder_;
};

constexpr const char* kPlant = R"(
takt: 1
lines:
  - name: first
    port: /dev/ttyS6
    devices:
      - name: Pump
        address: 5
        variables:
          - {name: Speed, type: int16, register: 0, read: 0x03, period: 1s}
  - name: bus
    port: /dev/ttyS7
locals:
  - {name: Limit, type: int16, default: 30}
servers:
  - name: a
    listen: 127.0.0.1
    tcp_port: 1502
    audit: audit.log
    relay:
      - {line: bus, units: [5..8], map: [{from: 9, to: 5}]}
    units:
      - address: 1
        banks:
          - {area: holding_register, items: [0..9, 20..29], read_only: [9], retain: [2..4]}
          - {area: coil, items: [0..15], overlay: holding_register, overlay_register: 0}
        limits:
          - {registers: [1], least: 0, greatest: 100}
        identification:
          - {id: 0, text: Vendor}
          - {id: 1, text: Product}
          - {id: 2, text: "1.0"}
        server_id: tanks
        variables:
          - {name: Level, type: float, area: holding_register, register: 20, default: 1.5}
          - {name: Shown, type: int16, area: holding_register, register: 5, source: {local: Limit}}
  - name: b
    listen: 127.0.0.1
    tcp_port: 1503
    access:
      - {functions: [read], rule: allow}
    units:
      - address: 1
        banks:
          - {area: holding_register, items: [0..9]}
)";

TEST_F(EndpointTest, UnitsHaveWhatTheProjectSays) {
    Bench bench(kPlant, folder_.path());
    EXPECT_EQ(bench.ask(0, 1, "03 00 14 00 02"), "03 04 00 00 3F C0") << "the default value";
    EXPECT_EQ(bench.ask(0, 1, "03 00 0A 00 01"), "83 02");
    EXPECT_EQ(bench.ask(0, 1, "06 00 09 00 01"), "86 02") << "read only";
    EXPECT_EQ(bench.ask(0, 1, "06 00 01 00 65"), "86 03") << "beyond its limit";
    EXPECT_EQ(bench.ask(0, 1, "05 00 03 FF 00"), "05 00 03 FF 00");
    EXPECT_EQ(bench.ask(0, 1, "03 00 00 00 01"), "03 02 00 08") << "the coil is its bit";
    EXPECT_EQ(bench.ask(0, 1, "11"), "11 07 01 FF 74 61 6E 6B 73");
    EXPECT_EQ(bench.ask(0, 1, "2B 0E 01 00").substr(0, 5), "2B 0E");
    EXPECT_EQ(bench.ask(1, 1, "11"), "91 01");
}

TEST_F(EndpointTest, BindingsWorkOnceTheyAreConnected) {
    Bench bench(kPlant, folder_.path());
    EXPECT_EQ(bench.ask(0, 1, "03 00 05 00 01"), "83 0B");
    ASSERT_TRUE(bench.set->open());
    EXPECT_EQ(bench.ask(0, 1, "03 00 05 00 01"), "03 02 00 1E");
    EXPECT_EQ(bench.ask(0, 1, "06 00 05 00 07"), "06 00 05 00 07") << "a local is written at once";
    EXPECT_EQ(bench.ask(0, 1, "03 00 05 00 01"), "03 02 00 07");
    (void)bench.set->close();
}

TEST_F(EndpointTest, RetainedRegistersSurvive) {
    for (const char* const expected : {"03 02 00 00", "03 02 00 2A"}) {
        Bench bench(kPlant, folder_.path());
        test::Answers answers;
        (*bench.set)[0].handler().pending().add(answers);
        ASSERT_TRUE(bench.set->open());
        EXPECT_EQ(bench.ask(0, 1, "03 00 03 00 01"), expected);
        const auto answered = bench.ask(0, 1, "06 00 03 00 2A");
        const auto statistics = bench.set->close();
        if (answered == "pending") {
            EXPECT_EQ(answers.of(bench.token), "06 00 03 00 2A");
        }
        ASSERT_EQ(statistics.retained.size(), 1u);
        EXPECT_EQ(statistics.retained[0].file, folder_ / "plant.a-1.registers");
    }
}

TEST_F(EndpointTest, RelaysToTheLinesThatItNames) {
    Bench bench(kPlant, folder_.path());
    EXPECT_EQ(bench.relayed, std::vector<std::size_t>{1});
    EXPECT_EQ(units_text((*bench.set)[0].handler().units()), "1, 5..9");
    EXPECT_EQ(bench.ask(0, 9, "03 00 00 00 01"), "83 0A") << "the line is closed";
    EXPECT_EQ(bench.ask(0, 10, "03 00 00 00 01"), "83 0A") << "no route";
    ASSERT_TRUE(bench.set->open());
    const auto statistics = bench.set->close();
    ASSERT_EQ(statistics.relayed.size(), 1u);
    EXPECT_EQ(statistics.relayed[0].line, 1u);
    EXPECT_EQ(statistics.relayed[0].counters.asked, 1u);
    EXPECT_EQ(statistics.relayed[0].counters.no_path, 1u);
}

TEST_F(EndpointTest, ARelayedAnswerComesBackToItsEndpoint) {
    Bench bench(kPlant, folder_.path());
    test::Answers answers;
    (*bench.set)[0].handler().pending().add(answers);
    ASSERT_TRUE(bench.set->open());
    bench.line.up = true;
    bench.set->after_line_event(line::now(), 1);
    bench.set->after_line_event(line::now(), 0);  // is not relayed to
    EXPECT_EQ(bench.ask(0, 9, "06 00 07 00 2A"), "pending");
    ASSERT_TRUE(bench.loop->run_until([&] { return bench.line.flight.has_value(); }, kDeadline));
    EXPECT_EQ(bench.line.flight->unit, UnitId{5}) << "unit 9 is mapped";
    bench.line.answer("06 00 07 00 2A");
    bench.set->after_line_event(line::now(), 1);
    ASSERT_TRUE(bench.loop->run_until([&] { return answers.has(bench.token); }, kDeadline));
    EXPECT_EQ(answers.of(bench.token), "06 00 07 00 2A");
    const auto statistics = bench.set->close();
    EXPECT_EQ(statistics.relayed.at(0).counters.sent, 1u);
    EXPECT_NE(audit().find(R"("unit":9)"), std::string::npos);
}

TEST_F(EndpointTest, WritesAreAudited) {
    Bench bench(kPlant, folder_.path());
    ASSERT_TRUE(bench.set->open());
    (void)bench.ask(0, 1, "06 00 07 00 2A");
    (void)bench.ask(1, 1, "06 00 07 00 2A");
    (void)bench.set->close();
    const std::string log = audit();
    EXPECT_EQ(std::ranges::count(log, '\n'), 1) << "the other server has no log";
    EXPECT_EQ(bench.audited, std::vector<std::string>{log});
    EXPECT_NE(log.find(R"("start":7,"count":1,"old":[0],"new":[42])"), std::string::npos) << log;
    EXPECT_EQ(bench.notices.codes(), "endpoint.access.in_force endpoint.registers.new ");
}

TEST_F(EndpointTest, RulesAreReplacedByServer) {
    Bench bench(kPlant, folder_.path());
    ASSERT_TRUE(bench.set->open());
    EXPECT_EQ(bench.notices.all[0].code, "endpoint.access.in_force");
    EXPECT_EQ(bench.ask(1, 1, "06 00 07 00 2A"), "86 01");
    auto changed = bench.plant;
    changed.servers[0].access = changed.servers[1].access;
    changed.servers[1].access.clear();
    std::swap(changed.servers[0], changed.servers[1]);
    EXPECT_TRUE(bench.set->set_access(changed));
    EXPECT_EQ(bench.notices.argument("count"), "1");
    EXPECT_EQ(bench.ask(0, 1, "06 00 07 00 2A"), "86 01");
    EXPECT_EQ(bench.ask(1, 1, "06 00 07 00 2A"), "06 00 07 00 2A");
    changed.servers.pop_back();
    EXPECT_FALSE(bench.set->set_access(changed)) << "a server is missing: nothing changes";
    EXPECT_EQ(bench.ask(0, 1, "06 00 07 00 2A"), "86 01");
    bench.set->set_access(std::vector<model::AccessRule>(2));
    EXPECT_EQ(bench.notices.argument("count"), "2");
    EXPECT_EQ(bench.ask(1, 1, "03 00 00 00 01"), "83 01") << "at all endpoints";
    (void)bench.set->close();
}

constexpr const char* kNewLine = R"(lines:
  - name: new
    port: /dev/ttyS9
    devices:
      - {name: Fan, address: 6, variables: [{name: Turns, type: int16, register: 0, read: 0x03, period: 1s}]}
)";

/// `text` with `from` replaced by `to`.
std::string changed(std::string text, std::string_view from, std::string_view to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST_F(EndpointTest, AServerThatContinuesKeepsWhatItHas) {
    Bench bench(kPlant, folder_.path());
    test::Answers answers;
    (*bench.set)[0].handler().pending().add(answers);
    ASSERT_TRUE(bench.set->open());
    auto* const kept = &(*bench.set)[0];
    (void)bench.ask(0, 1, "06 00 07 00 2A");
    (void)bench.ask(0, 1, "06 00 03 00 2B");  // retained
    (void)bench.ask(1, 1, "06 00 07 00 2A");
    // Another line and another server before them, another local, other rules; and one server has changed.
    auto yaml = changed(kPlant, "lines:\n", kNewLine);
    yaml = changed(yaml, "default: 30}", "default: 31}\n  - {name: More, type: int16, default: 1}");
    yaml = changed(yaml, "    audit: audit.log\n",
                   "    audit: audit.log\n    access: [{functions: [read], rule: allow}]\n");
    yaml = changed(yaml, "tcp_port: 1503", "tcp_port: 1504");
    ASSERT_TRUE(bench.apply(yaml));
    ASSERT_EQ(bench.set->size(), 2u);
    EXPECT_EQ(&(*bench.set)[0], kept);
    EXPECT_EQ(bench.ask(0, 1, "03 00 07 00 01"), "03 02 00 2A");
    EXPECT_EQ(bench.ask(0, 1, "06 00 07 00 2B"), "86 01") << "the rules of the new project";
    EXPECT_EQ(bench.ask(0, 1, "03 00 05 00 01"), "03 02 00 1F") << "the local of the new project";
    EXPECT_EQ(bench.ask(1, 1, "03 00 07 00 01"), "03 02 00 00");
    ASSERT_TRUE(bench.loop->run_until([&] { return !answers.given.empty(); }, kDeadline))
        << "of the retained write";
    const auto statistics = bench.set->close();
    ASSERT_EQ(statistics.relayed.size(), 1u);
    EXPECT_EQ(statistics.relayed[0].line, 2u) << "its line has another number";
    EXPECT_NE(audit().find("refused"), std::string::npos) << "the log goes on";
}

TEST_F(EndpointTest, ARelayedRequestThatWaitsIsSentAfterTheChange) {
    Bench bench(kPlant, folder_.path());
    test::Answers answers;
    (*bench.set)[0].handler().pending().add(answers);
    ASSERT_TRUE(bench.set->open());
    bench.line.up = true;
    bench.line.sent = false;
    bench.set->after_line_event(line::now(), 1);
    EXPECT_EQ(bench.ask(0, 9, "06 00 07 00 2A"), "pending");
    ASSERT_TRUE(bench.loop->run_until([&] { return bench.line.flight.has_value(); }, kDeadline));
    bench.next = std::make_unique<model::Project>(test::project(changed(kPlant, "lines:\n", kNewLine)));
    bench.next_values = std::make_unique<LocalValues>(*bench.next);
    bench.set->leave(*bench.next);
    EXPECT_FALSE(bench.line.flight) << "taken back";
    ASSERT_TRUE(bench.set->enter(bench.specs(*bench.next), bench.served(*bench.next, *bench.next_values)));
    ASSERT_TRUE(bench.loop->run_until([&] { return bench.line.flight.has_value(); }, kDeadline));
    EXPECT_EQ(bench.relayed.size(), 1u) << "the gateway is the same";
    bench.line.answer("06 00 07 00 2A");
    bench.set->after_line_event(line::now(), 1);
    EXPECT_FALSE(answers.has(bench.token)) << "it is line 2 now";
    bench.set->after_line_event(line::now(), 2);
    ASSERT_TRUE(bench.loop->run_until([&] { return answers.has(bench.token); }, kDeadline));
    EXPECT_EQ(answers.of(bench.token), "06 00 07 00 2A");
    (void)bench.set->close();
}

TEST_F(EndpointTest, AServerThatGoesClosesItsRelayedRequestsAndItsLog) {
    Bench bench(kPlant, folder_.path());
    ASSERT_TRUE(bench.set->open());
    bench.line.up = true;
    bench.line.sent = false;
    bench.set->after_line_event(line::now(), 1);
    EXPECT_EQ(bench.ask(0, 9, "06 00 07 00 2A"), "pending");
    const std::string all = changed(kPlant, "  - name: bus\n    port: /dev/ttyS7\n", "");
    ASSERT_TRUE(
        bench.apply(all.substr(0, all.find("  - name: a\n")) + all.substr(all.find("  - name: b\n"))));
    ASSERT_EQ(bench.set->size(), 1u);
    EXPECT_NE(audit().find("not_sent"), std::string::npos) << audit();
    EXPECT_EQ(bench.ask(0, 1, "03 00 00 00 01"), "03 02 00 00");
    EXPECT_TRUE(bench.set->close().relayed.empty());
}

TEST_F(EndpointTest, AServerThatCannotOpenLeavesTheOthersAtWork) {
    Bench bench(kPlant, folder_.path());
    ASSERT_TRUE(bench.set->open());
    (void)bench.ask(0, 1, "06 00 07 00 2A");
    const auto opened =
        bench.apply(changed(kPlant, "    tcp_port: 1503\n", "    tcp_port: 1503\n    audit: .\n"));
    EXPECT_FALSE(opened);
    ASSERT_EQ(bench.set->size(), 1u);
    EXPECT_EQ(bench.ask(0, 1, "03 00 07 00 01"), "03 02 00 2A");
    (void)bench.set->close();
}

TEST_F(EndpointTest, AFileThatCannotBeIsAnError) {
    Bench bench(kPlant, folder_ / "nowhere");
    const auto opened = bench.set->open();
    ASSERT_FALSE(opened);
    EXPECT_EQ(opened.error().code, Code::cannot_open);
    const auto statistics = bench.set->close();
    EXPECT_TRUE(statistics.listeners.empty());
}

TEST(ServerEndpoint, IsLaidOutAsTheProjectSaysAndFilled) {
    const auto loop = line::Loop::create().value();
    test::Notices notices;
    const auto plant = test::project(R"(
takt: 1
servers:
  - name: s
    listen: 127.0.0.1
    tcp_port: 1502
    units:
      - address: 3
        banks:
          - {area: holding_register, items: [10..19, 30..31], read_only: [19]}
          - {area: coil, items: [5..8]}
        limits: [{registers: [10..12], least: -5, greatest: 5}]
        identification: [{id: 1, text: Second}, {id: 0, text: First}]
        server_id: takt
        files: [{number: 4, records: 3}]
        fifos: [{register: 100, values: [7, 8]}]
        variables:
          - {name: Off, type: bool, area: coil, coil: 7, default: false}
          - {name: Bit, type: bool, area: holding_register, register: 31, bit: 0, default: false}
)");
    const Environment environment{*loop, notices.sink()};
    Endpoint endpoint(0, server_endpoints(plant, "p.yaml", {.fill = sim::Fill::ramp}, false).at(0),
                      environment);
    const auto ask = [&](std::string_view request) {
        return to_hex(
            endpoint.handler()
                .handle({line::now(), UnitId{3}, false, "", {}}, wire::RequestView(pdu(request).span()))
                .pdu.span());
    };
    EXPECT_EQ(ask("03 00 0A 00 02"), "03 04 00 0A 00 0B");
    EXPECT_EQ(ask("03 00 1E 00 02"), "03 04 00 1E 00 1E") << "bit 0 of register 31 has a default";
    EXPECT_EQ(ask("01 00 05 00 04"), "01 01 01") << "of the coils 5 and 7 the second has a default";
    EXPECT_EQ(ask("03 00 09 00 02"), "83 02");
    EXPECT_EQ(ask("06 00 13 00 01"), "86 02");
    EXPECT_EQ(ask("06 00 0A FF FB"), "06 00 0A FF FB");
    EXPECT_EQ(ask("06 00 0A FF FA"), "86 03");
    EXPECT_EQ(ask("04 FF FF 00 01"), "84 02");
    EXPECT_EQ(ask("11").substr(0, 5), "11 06");
    EXPECT_EQ(ask("14 07 06 00 04 00 01 00 02"), "14 06 05 06 00 01 00 02");
    EXPECT_EQ(ask("18 00 64"), "18 00 06 00 02 00 07 00 08");
    EXPECT_EQ(ask("2B 0E 04 01"), "2B 0E 04 81 00 00 01 01 06 53 65 63 6F 6E 64");
}

TEST(BlankEndpoint, HasAllItems) {
    const auto loop = line::Loop::create().value();
    test::Notices notices;
    const Environment environment{*loop, notices.sink()};
    Endpoint endpoint(0, *blank_endpoint(UnitId{3}, {.fill = sim::Fill::ramp}), environment);
    const auto ask = [&](std::string_view request) {
        return to_hex(
            endpoint.handler()
                .handle({line::now(), UnitId{3}, false, "", {}}, wire::RequestView(pdu(request).span()))
                .pdu.span());
    };
    EXPECT_EQ(ask("04 FF FF 00 01"), "04 02 FF FF");
    EXPECT_EQ(ask("02 FF F8 00 08"), "02 01 AA");
    EXPECT_EQ(ask("11"), "11 06 03 FF 74 61 6B 74");
    EXPECT_EQ(ask("14 07 06 00 04 00 01 00 02"), "94 01");
}

TEST(DeviceEndpoint, AnswersForTheDevicesOfALine) {
    const auto loop = line::Loop::create().value();
    test::Notices notices;
    const auto plant = test::project(R"(
takt: 1
lines:
  - name: bus
    transport: tcp
    host: 127.0.0.1
    tcp_port: 1502
    devices:
      - name: Pump
        address: 5
        variables:
          - {name: Speed, type: int16, register: 7, read: 0x03, write: 0x06}
)");
    const Environment environment{*loop, notices.sink()};
    Endpoint endpoint(0, device_endpoints(plant, {})->at(0), environment);
    const auto ask = [&](std::string_view request) {
        return to_hex(
            endpoint.handler()
                .handle({line::now(), UnitId{5}, false, "", {}}, wire::RequestView(pdu(request).span()))
                .pdu.span());
    };
    EXPECT_EQ(ask("06 00 07 00 2A"), "06 00 07 00 2A");
    EXPECT_EQ(ask("03 00 07 00 01"), "03 02 00 2A");
    EXPECT_EQ(ask("03 00 08 00 01"), "83 02");
}

TEST(UnitsText, RunsOfMoreThanThree) {
    EXPECT_EQ(units_text({}), "");
    EXPECT_EQ(units_text({UnitId{3}, UnitId{1}, UnitId{2}}), "1, 2, 3");
    EXPECT_EQ(units_text({UnitId{1}, UnitId{2}, UnitId{3}, UnitId{4}, UnitId{9}}), "1..4, 9");
}

}  // namespace endpoint_test
}  // namespace takt::endpoint
