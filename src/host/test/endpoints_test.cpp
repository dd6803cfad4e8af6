// The servers of a project at work, asked without a port: what is written to them reaches the devices, and
// what is left of them when another project or the end comes.
#include "engine/endpoints.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "../../endpoint/test/support.hpp"
#include "folder.hpp"
#include "projects.hpp"
#include "rig.hpp"

namespace takt::host::test {
namespace endpoints_test {

using endpoint::test::Answers;
using endpoint::test::pdu;
using endpoint::test::to_hex;

constexpr Duration kDeadline = 30s;  // of what happens at once

const std::string kUnit = R"(    units:
      - address: 1
        banks:
          - {area: holding_register, items: [0..9]}
)";

/// A server with registers 0..9 at unit 1; a write of register 1 sets Setpoint; unit 2 is that of the line.
const std::string kPanel = R"(  - name: panel
    listen: 127.0.0.1
    tcp_port: 1502
    audit: audit.log
    relay:
      - {line: main, units: [2]}
)" + kUnit +
                           R"(        variables:
          - {name: Wanted, type: int16, area: holding_register, register: 1, writes_to: {variable: Setpoint}}
          - {name: Shown, type: int16, area: holding_register, register: 2, source: {variable: Level}}
)";

/// A server with registers 0..9 at unit 1 and nothing else.
std::string server_of(const std::string& name, int port) {
    return "  - name: " + name + "\n    listen: 127.0.0.1\n    tcp_port: " + std::to_string(port) + '\n' +
           kUnit;
}

std::string plant_with(const std::string& servers, const std::string& lines_before = "") {
    const std::string slow = ", response_timeout: 60s";
    return project_with(
        lines_before +
            line_of(
                "main",
                device_of("Boiler", 1, variable_of("Level", 0) + variable_of("Setpoint", 10, kOnChange),
                          slow) +
                    device_of("Pump", 2, variable_of("Speed", 0) + variable_of("Limit", 3, kOnChange), slow),
                "tcp"),
        {}, servers);
}

/// The servers of a plant on simulated lines, without their listeners.
class ServedPlant {
public:
    explicit ServedPlant(const std::string& yaml) : rig(yaml, {}, line::now()) {
        auto opened =
            Endpoints::open({.loop = *loop,
                             .link = *rig.link,
                             .specs =
                                 [this](const model::Project& project) {
                                     auto specs =
                                         endpoint::server_endpoints(project, folder / "plant.yaml", {}, true);
                                     for (auto& spec : specs) spec.listeners.clear();
                                     return specs;
                                 },
                             .now = [this] { return rig.now; },
                             .engine = [this]() -> ProjectEngine& { return *rig.engine; },
                             .notify = [this](const Notice& notice) { notices.push_back(notice.code); },
                             .log = [](std::string_view) { return Log(); },
                             .poke = [this](std::size_t line) { rig.poke(line); }});
        if (!opened) throw std::runtime_error("servers");
        endpoints = *std::move(opened);
        rig.endpoints = endpoints.get();
        endpoints->after_line_event(rig.now, 0);  // it is up already
        (*endpoints)[0].handler().pending().add(answers);
    }

    /// The answer, or "pending".
    std::string ask(std::size_t server, int unit, std::string_view request) {
        const serve::Context context{
            rig.now, UnitId{static_cast<std::uint8_t>(unit)}, false, "192.0.2.1:5", {}};
        const auto answer =
            (*endpoints)[server].handler().handle(context, wire::RequestView(pdu(request).span()));
        token = answer.token;
        return answer.kind == serve::Answer::Kind::pending ? "pending" : to_hex(answer.pdu.span());
    }

    /// Asks through the relay: the request is on the line, and virtual time has caught up with the loop.
    void relay(std::string_view request) {
        ASSERT_EQ(ask(0, 2, request), "pending");
        ASSERT_TRUE(loop->run_until([this] { return !rig.engine->master().line(0).can_relay(); }, kDeadline));
        rig.now = std::max(rig.now, line::now());
    }

    /// The loop delivers the answer to the relayed request.
    [[nodiscard]] std::string relayed_answer() {
        rig.run(20ms);
        EXPECT_TRUE(loop->run_until([this] { return answers.has(token); }, kDeadline));
        return answers.of(token);
    }

    std::uint16_t register_of(std::uint8_t unit, std::uint16_t address) {
        const serve::Context context{rig.now, UnitId{unit}, false, "", {}};
        const std::uint8_t request[] = {3, static_cast<std::uint8_t>(address >> 8),
                                        static_cast<std::uint8_t>(address), 0, 1};
        const auto answer = rig.devices(0).handle(context, wire::RequestView(request));
        return static_cast<std::uint16_t>(answer.pdu[2] << 8 | answer.pdu[3]);
    }

    [[nodiscard]] endpoint::Statistics counted() {
        return rig.snapshot({.endpoints = true})->snapshot.endpoints;
    }

    const takt::test::Folder folder;
    std::unique_ptr<line::Loop> loop = line::Loop::create().value();
    Rig rig;
    Answers answers;
    std::vector<std::string> notices;
    std::unique_ptr<Endpoints> endpoints;
    serve::Token token = 0;
};

/// The lines of the audit log that a session got as events.
std::string audited(Session& session) {
    std::string lines;
    for (const auto& event : take_events_of<AuditRecorded>(session))
        lines += endpoint::audit_line(event.record);
    return lines;
}

TEST(Endpoints, AWriteIsAnsweredWhenTheDeviceHasIt) {
    ServedPlant plant(plant_with(kPanel));
    const auto session = plant.rig.open();
    ASSERT_EQ(plant.ask(0, 1, "06 00 01 00 2A"), "pending");
    EXPECT_FALSE(plant.answers.has(plant.token));
    plant.rig.run(200ms);
    EXPECT_EQ(plant.answers.of(plant.token), "06 00 01 00 2A");
    EXPECT_EQ(plant.register_of(1, 10), 42);
    (void)plant.endpoints->close();
    const auto lines = audited(*session);
    EXPECT_EQ(lines, plant.folder.read("audit.log"));
    EXPECT_EQ(std::ranges::count(lines, '\n'), 1);
    EXPECT_NE(lines.find(R"("peer":"192.0.2.1:5")"), std::string::npos) << lines;
}

TEST(Endpoints, ReadsGiveTheValuesOfTheLines) {
    ServedPlant plant(plant_with(kPanel));
    EXPECT_EQ(plant.ask(0, 1, "03 00 02 00 01"), "83 0B") << "not read yet";
    plant.rig.run(500ms);
    const auto level =
        std::get<std::int64_t>(plant.rig.engine->master().store()[plant.rig.slot("Level")].value);
    const std::uint8_t expected[] = {3, 2, static_cast<std::uint8_t>(level >> 8),
                                     static_cast<std::uint8_t>(level)};
    EXPECT_EQ(plant.ask(0, 1, "03 00 02 00 01"), to_hex(expected));
}

TEST(Endpoints, ARelayedWriteSharesTheLineWithPolling) {
    ServedPlant plant(plant_with(kPanel));
    ASSERT_NO_FATAL_FAILURE(plant.relay("06 00 03 00 2B"));
    EXPECT_EQ(plant.relayed_answer(), "06 00 03 00 2B");
    EXPECT_EQ(plant.register_of(2, 3), 43);
    EXPECT_EQ(plant.rig.engine->master().line(0).device(1).state, poll::DeviceState::answering);
}

TEST(Endpoints, WritesThatAreUnansweredAtTheEndAreAuditedBeforeIt) {
    ServedPlant plant(plant_with(kPanel));
    for (const UnitId unit : {UnitId{1}, UnitId{2}}) plant.rig.devices(0).find(unit)->behaviour.dead = true;
    const auto session = plant.rig.open();
    ASSERT_NO_FATAL_FAILURE(plant.relay("06 00 03 00 2B"));
    ASSERT_EQ(plant.ask(0, 1, "06 00 01 00 2A"), "pending");
    plant.rig.run(500ms);
    plant.rig.engine->finish(plant.rig.now);
    (void)plant.endpoints->close();
    const auto lines = audited(*session);
    EXPECT_EQ(lines, plant.folder.read("audit.log"));
    EXPECT_NE(lines.find(R"("unit":1)"), std::string::npos) << lines;
    EXPECT_NE(lines.find(R"("event":"refused")"), std::string::npos) << "what was not written to the device";
    EXPECT_NE(lines.find(R"("unit":2)"), std::string::npos) << "it may have been executed";
    EXPECT_EQ(session->missed_events(), 0U);
}

TEST(Endpoints, SnapshotsHaveTheirStatistics) {
    ServedPlant plant(plant_with(kPanel));
    ASSERT_NO_FATAL_FAILURE(plant.relay("03 00 00 00 01"));
    EXPECT_EQ(plant.relayed_answer().substr(0, 5), "03 02");
    EXPECT_TRUE(plant.rig.snapshot({})->snapshot.endpoints.relayed.empty()) << "not asked for";
    const auto running = plant.counted();
    ASSERT_EQ(running.relayed.size(), 1U);
    EXPECT_EQ(running.relayed[0].counters.asked, 1U);
    EXPECT_EQ(running.relayed[0].counters.sent, 1U);
    const auto closed = plant.endpoints->close();
    ASSERT_EQ(closed.relayed.size(), 1U);
    EXPECT_EQ(closed.relayed[0].counters.sent, 1U);
}

TEST(Endpoints, MemoryForOtherServersIsNotFilled) {
    ServedPlant plant(plant_with(kPanel));
    const auto before = plant.rig.link->endpoint_names();
    plant.rig.apply(plant_with(server_of("other", 1503)));
    const auto names = plant.rig.link->endpoint_names();
    endpoint::Statistics into = *names;
    EXPECT_FALSE(plant.endpoints->copy_counters(before, into));
    EXPECT_TRUE(plant.endpoints->copy_counters(names, into));
}

// The line has another number in the other project, and the server another place.
TEST(Endpoints, AServerThatDidNotChangeGoesOnWithAnotherProject) {
    ServedPlant plant(plant_with(kPanel + server_of("other", 1503)));
    ASSERT_EQ(plant.ask(0, 1, "06 00 05 00 2A"), "06 00 05 00 2A");
    ASSERT_EQ(plant.ask(1, 1, "06 00 05 00 2A"), "06 00 05 00 2A");
    ASSERT_NO_FATAL_FAILURE(plant.relay("03 00 00 00 01"));
    EXPECT_EQ(plant.relayed_answer().substr(0, 5), "03 02");
    for (int turn = 1; turn <= 5; ++turn) {
        plant.rig.apply(plant_with(server_of("other", 1503 + turn) + kPanel,
                                   line_of("first", device_of("Fan", 2, variable_of("Turns", 0)), "tcp")));
        EXPECT_EQ(plant.ask(1, 1, "03 00 05 00 01"), "03 02 00 2A") << "the register is kept";
        EXPECT_EQ(plant.ask(0, 1, "03 00 05 00 01"), "03 02 00 00") << "this server has changed";
    }
    const auto counted = plant.counted();
    ASSERT_EQ(counted.relayed.size(), 1U);
    EXPECT_EQ(counted.relayed[0].line, 1U);
    EXPECT_EQ(counted.relayed[0].counters.sent, 1U) << "counted from before";
    ASSERT_EQ(plant.ask(1, 1, "06 00 01 00 2B"), "pending");
    plant.rig.run(500ms);
    EXPECT_EQ(plant.answers.of(plant.token), "06 00 01 00 2B") << "by the engine of the new project";
}

TEST(Endpoints, NoSnapshotHasTheServersAfterTheirEnd) {
    ServedPlant plant(plant_with(kPanel));
    EXPECT_TRUE(plant.rig.link->endpoint_names());
    (void)plant.endpoints->close();
    plant.rig.endpoints = nullptr;
    plant.endpoints.reset();
    EXPECT_FALSE(plant.rig.link->endpoint_names());
    EXPECT_TRUE(plant.counted().relayed.empty());
}

TEST(Endpoints, RulesOfAnotherProjectComeIntoForce) {
    ServedPlant plant(plant_with(kPanel));
    auto changed = project_of(plant_with(kPanel + "    access: [{functions: [read], rule: allow}]\n"));
    EXPECT_TRUE(plant.endpoints->set_access(changed));
    EXPECT_EQ(plant.notices, std::vector<std::string>{"endpoint.access.in_force"});
    EXPECT_EQ(plant.ask(0, 1, "06 00 05 00 2A"), "86 01");
    changed.servers.clear();
    EXPECT_FALSE(plant.endpoints->set_access(changed));
}

}  // namespace endpoints_test
}  // namespace takt::host::test
