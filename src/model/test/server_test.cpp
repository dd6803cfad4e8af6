// `servers:` of a project: the meaning of each key, and the finding of each mistake.
#include <gtest/gtest.h>

#include <string>

#include "flow.hpp"
#include "takt/model/findings.hpp"

namespace takt::model::test {
namespace server_test {

using namespace std::chrono_literals;

Checked read(const std::string& servers) {
    const std::string project = "{lines: ~, locals: ~, servers: [" + servers + "]}";
    return interpret(document({.project = project}));
}

std::string findings_text(const std::string& servers) {
    std::string all;
    for (const auto& finding : read(servers).findings) {
        if (!all.empty()) all += "; ";
        if (finding.severity == Severity::warning) all += '?';
        all += finding.code + " " + finding.path.substr(finding.path.rfind('.') + 1) + "=" + finding.value;
        if (!finding.allowed.empty()) all += " [" + finding.allowed + "]";
    }
    return all;
}

/// A server with one unit that has these keys beside two banks.
std::string unit(const std::string& keys) {
    return "{name: S, listen: ::, units: [{address: 1, banks: [{area: holding_register, items: [0..9, "
           "20..29]}, "
           "{area: coil, items: [0..99]}]" +
           (keys.empty() ? "" : ", " + keys) + "}]}";
}

/// Two servers with these keys.
std::string two(const std::string& one, const std::string& other) {
    return "{name: S, " + one + ", units: [{address: 1, banks: []}]}, {name: T, " + other +
           ", units: [{address: 1, banks: []}]}";
}

/// A unit with one bank of that area, with these keys.
std::string bank(const std::string& keys) {
    return "{name: S, listen: x, units: [{address: 1, banks: [{area: " + keys + "}]}]}";
}

TEST(Servers, AWholeOne) {
    const auto checked = read(
        "{name: S, listen: 127.0.0.1, tcp_port: 1502, max_connections: 7, max_per_peer: 3, idle_timeout: "
        "5s, "
        "units: ["
        "{address: 3, banks: [{area: holding_register, items: [0..9, 20..29], read_only: [3, 4], retain: "
        "[2..9]}, "
        "{area: coil, items: [0..63], overlay: holding_register, overlay_register: 2}], "
        "durability: 100ms, state: kept/tank.registers, "
        "limits: [{registers: [0..1], least: -5, greatest: 5}], "
        "identification: [{id: 2, text: '1'}, {id: 0, text: V}], server_id: P, "
        "files: [{number: 4, records: 100, read_only: true}], fifos: [{register: 7, values: [1, 0x10]}], "
        "exception_coils: 8, restart: true, listen_only: true, high_register_first: true, "
        "variables: [{name: Level, type: float, area: holding_register, register: 20, default: 1.5, used: "
        "true, comment: c}]}]}");
    ASSERT_TRUE(checked.findings.empty()) << checked.findings.front().code << checked.findings.front().path;
    const Server& server = checked.project.servers.at(0);
    EXPECT_EQ(server.transport, Transport::tcp);
    EXPECT_EQ(server.port, "127.0.0.1");
    EXPECT_EQ(server.tcp_port, 1502);
    EXPECT_EQ(server.framing, wire::Framing::tcp);
    EXPECT_EQ(server.limits.max_connections, 7U);
    EXPECT_EQ(server.limits.max_per_peer, 3U);
    EXPECT_EQ(server.limits.idle_timeout, 5s);
    const ServerUnit& unit = server.units.at(0);
    EXPECT_EQ(unit.address, UnitId{3});
    const std::vector<ItemRange> registers{{0, 9}, {20, 29}};
    const std::vector<ItemRange> read_only{{3, 4}};
    EXPECT_EQ(unit.offered[3], registers);
    EXPECT_EQ(unit.read_only[3], read_only);
    const std::vector<ItemRange> retained{{2, 9}};
    EXPECT_EQ(unit.retained[3], retained);
    EXPECT_EQ(unit.durability, Durability::interval);
    EXPECT_EQ(unit.state, "kept/tank.registers");
    ASSERT_TRUE(unit.overlays[0]);
    EXPECT_EQ(unit.overlays[0]->area, wire::Area::holding_register);
    EXPECT_EQ(unit.overlays[0]->first, 2);
    EXPECT_FALSE(unit.overlays[1]);
    ASSERT_EQ(unit.limits.size(), 1u);
    EXPECT_EQ(unit.limits[0].least, -5);
    EXPECT_EQ(unit.limits[0].greatest, 5);
    ASSERT_EQ(unit.identification.size(), 2u);
    EXPECT_EQ(unit.identification[0].text, "V") << "by id";
    EXPECT_EQ(unit.server_id, "P");
    EXPECT_EQ(unit.files.at(0).number, 4);
    EXPECT_TRUE(unit.files.at(0).read_only);
    EXPECT_EQ(unit.fifos.at(0).values, (std::vector<std::uint16_t>{1, 16}));
    EXPECT_EQ(unit.exception_coils, 8);
    EXPECT_TRUE(unit.may_restart);
    EXPECT_TRUE(unit.may_listen_only);
    const Variable& variable = unit.variables.at(0);
    EXPECT_EQ(variable.name, "Level");
    EXPECT_EQ(variable.area, wire::Area::holding_register);
    EXPECT_EQ(variable.start(), 20);
    EXPECT_TRUE(variable.order.high_register_first);
    ASSERT_TRUE(variable.default_value);
    EXPECT_EQ(variable.default_value->number, 1.5);
}

TEST(Servers, OnASerialLine) {
    const auto checked = read(
        "{name: S, transport: serial, port: /dev/ttyS1, framing: ascii, baud: 9600, "
        "turnaround: 2ms, "
        "units: [{address: 7, banks: []}]}");
    ASSERT_TRUE(checked.findings.empty()) << checked.findings.front().code;
    const Server& server = checked.project.servers.at(0);
    EXPECT_EQ(server.transport, Transport::serial);
    EXPECT_EQ(server.port, "/dev/ttyS1");
    EXPECT_EQ(server.framing, wire::Framing::ascii);
    EXPECT_EQ(server.format.baud, 9600u);
    EXPECT_EQ(server.format.data_bits, 7);
    EXPECT_EQ(server.turnaround, 2ms);
    EXPECT_FALSE(server.strict);
    EXPECT_TRUE(
        read("{name: S, transport: serial, port: p, strict: true, units: []}").project.servers.at(0).strict);
}

TEST(Servers, HaveTlsOnItsPort) {
    const auto server = read("{name: S, transport: tls, listen: *, units: []}").project.servers.at(0);
    EXPECT_EQ(server.tcp_port, 802);
    EXPECT_EQ(server.tls, files_in("certs/", "server"));
    EXPECT_EQ(
        findings_text("{name: S, transport: tls, listen: *, tls: {server_name: plc}, units: [{address: 1, "
                      "banks: [{area: coil, items: [0..9]}]}]}"),
        "field.needs server_name=plc");
}

TEST(Servers, AnAccessRuleNamesRoles) {
    const auto server =
        read("{name: S, listen: *, access: [{roles: [Operator, none], rule: allow}], units: []}")
            .project.servers.at(0);
    EXPECT_EQ(server.access.at(0).roles, (std::vector<std::string>{"Operator", ""}));
}

TEST(Servers, RetainAllOfABank) {
    const auto retained = [](const std::string& value) {
        const auto checked =
            read("{name: S, listen: x, units: [{address: 1, banks: [{area: coil, items: [0..7, 9], retain: " +
                 value + "}]}]}");
        EXPECT_TRUE(checked.findings.empty()) << checked.findings.front().code;
        return checked.project.servers.at(0).units.at(0).retained[0];
    };
    const std::vector<ItemRange> all{{0, 7}, {9, 9}};
    EXPECT_EQ(retained("true"), all);
    EXPECT_EQ(retained("false"), std::vector<ItemRange>{});
}

/// A project with two lines, one of them without devices.
Checked relayed(const std::string& relay, const std::string& units = "") {
    return interpret(document(
        {.project = "{lines: [{name: A, port: a, devices: [{name: D, address: 1}]}, {name: B, port: b, "
                    "relay_interval: 200ms}], locals: ~, servers: [{name: S, listen: x, relay: " +
                    relay + units + "}]}"}));
}

TEST(Servers, RelayToLines) {
    const auto checked = relayed(
        "[{line: B, units: [5..7, 9], map: [{from: 1, to: 17}, {from: 5, to: 2}], cache: 200ms, attempts: 3, "
        "response_timeout: 50ms, max_wait: 2s}, {line: B, response_timeout: 80ms}]");
    ASSERT_TRUE(checked.findings.empty()) << checked.findings.front().code << checked.findings.front().path;
    const Server& server = checked.project.servers.at(0);
    EXPECT_TRUE(server.units.empty());
    ASSERT_EQ(server.relays.size(), 2u);
    const Relay& relay = server.relays[0];
    EXPECT_EQ(relay.line, 1u);
    const std::vector<ItemRange> units{{5, 7}, {9, 9}};
    EXPECT_EQ(relay.units, units);
    ASSERT_EQ(relay.map.size(), 2u);
    EXPECT_EQ(relay.map[0].from, UnitId{1});
    EXPECT_EQ(relay.map[0].to, UnitId{17});
    EXPECT_EQ(relay.cache, 200ms);
    EXPECT_EQ(relay.attempts, 3);
    EXPECT_EQ(relay.response_timeout, 50ms);
    EXPECT_EQ(relay.max_wait, 2s);
    const std::vector<ItemRange> all{{1, 247}};
    EXPECT_EQ(server.relays[1].units, all);
    EXPECT_EQ(server.relays[1].attempts, 1);
    EXPECT_FALSE(checked.project.lines[0].relayed);
    ASSERT_TRUE(checked.project.lines[1].relayed);
    EXPECT_EQ(checked.project.lines[1].relayed->response_timeout, 80ms);
    EXPECT_FALSE(checked.project.lines[1].relayed->broadcast);
    EXPECT_EQ(checked.project.lines[1].relay_interval, 200ms);
    for (const char* everybody : {"[{line: B, units: [0..3]}]", "[{line: B, map: [{from: 9, to: 0}]}]"})
        EXPECT_TRUE(relayed(everybody).project.lines[1].relayed->broadcast) << everybody;
}

TEST(Servers, AMapAloneRelaysOnlyItsUnits) {
    const auto checked = relayed("[{line: B, map: [{from: 1, to: 17}]}]");
    ASSERT_TRUE(checked.findings.empty()) << checked.findings.front().code;
    EXPECT_TRUE(checked.project.servers.at(0).relays.at(0).units.empty());
}

TEST(Servers, MistakesInARelayAreReported) {
    const std::pair<const char*, const char*> rows[] = {
        {"[{line: C}]", "field.missing devices=; line.unknown line=C"},
        {"[{line: A}]", "field.missing devices="},
        {"[{line: B, units: [0..256]}]", "field.out_of_range units=256 [0..255]"},
        {"[{line: B, map: [{from: 1, to: 2}, {from: 1, to: 3}]}]", "number.twice from=1"},
        {"[{line: B, map: [{from: 1}]}]", "field.missing to="},
        {"[{line: B, attempts: 0}]", "field.out_of_range attempts=0 [1..10]"},
        {"[]", "field.missing devices=; field.empty relay="},
        {"[{units: [1]}]", "field.missing devices=; field.missing line="},
    };
    for (const auto& [relay, expected] : rows) {
        auto found = std::string();
        for (const auto& finding : relayed(relay).findings) {
            if (!found.empty()) found += "; ";
            found +=
                finding.code + " " + finding.path.substr(finding.path.rfind('.') + 1) + "=" + finding.value;
            if (!finding.allowed.empty() && finding.code != "field.missing")
                found += " [" + finding.allowed + "]";
        }
        EXPECT_EQ(found, expected) << relay;
    }
}

TEST(Servers, ARuleForAUnitBeforeAMapHasNoEffect) {
    const auto found = [](const std::string& relay, const std::string& more) {
        std::string all;
        for (const auto& finding : relayed(relay, more).findings) {
            EXPECT_EQ(finding.code, "field.without_effect");
            EXPECT_EQ(finding.severity, Severity::warning);
            all += finding.path.substr(finding.path.find("access")) + "=" + finding.value + " ";
        }
        return all;
    };
    const std::string map = "[{line: B, map: [{from: 100, to: 16}, {from: 101, to: 17}]}]";
    EXPECT_EQ(found(map, ", access: [{rule: allow}, {units: [100, 101], rule: deny}]"),
              "access[1].units=100 access[1].units=101 ");
    EXPECT_EQ(found(map, ", access: [{units: [1..100], rule: deny}]"), "")
        << "it has the unit behind the map";
    EXPECT_EQ(found(map, ", units: [{address: 100, banks: []}], access: [{units: [100], rule: deny}]"), "");
    EXPECT_EQ(
        found("[{line: B, map: [{from: 5, to: 2}], units: [5, 6]}]", ", access: [{units: [5], rule: deny}]"),
        "access[0].units=5 ");
    EXPECT_EQ(
        found("[{line: B, map: [{from: 5, to: 2}], units: [0]}]", ", access: [{units: [5], rule: deny}]"), "")
        << "a broadcast reaches unit 5";
}

struct Row {
    std::string servers;
    const char* expected;
};

TEST(Servers, MistakesAreReported) {
    const Row rows[] = {
        {unit(""), ""},
        {"{name: S, units: [{address: 1, banks: []}]}", "line.port_missing listen="},
        {"{name: S, listen: 127.0.0.1:15031, units: [{address: 1, banks: []}]}",
         "host.with_port listen=127.0.0.1:15031"},
        {"{name: S, listen: x, units: []}", "field.empty units="},
        {"{name: S, listen: x, baud: 9600, units: [{address: 256, banks: []}]}",
         "?field.without_effect baud=9600; field.out_of_range address=256 [0..255]"},
        {"{name: S, transport: serial, port: p, tcp_port: 5, framing: tcp, units: [{address: 1, banks: []}]}",
         "?field.without_effect tcp_port=5; field.not_here framing=tcp [rtu, ascii]"},
        {"{name: S, listen: x, units: [{address: 1, banks: []}, {address: 1, banks: []}]}",
         "address.duplicate address=1"},
        {"{name: S, listen: x, units: [{address: 1, banks: [{area: coil, items: [1]}, {area: coil, items: "
         "[2]}]}]}",
         "bank.twice area=coil"},
        {"{name: S, listen: x, units: [{address: 1, banks: [{area: input_register, items: [1], overlay: "
         "holding_register}]}]}",
         "bank.overlay_bits overlay=holding_register"},
        {"{name: S, listen: x, units: [{address: 1, banks: [{area: coil, items: [0..7, 9], retain: [3, "
         "6..9]}]}]}",
         "bank.retain_outside retain= [0..7, 9..9]"},
        {"", "field.empty servers="},
        {two("listen: *, tcp_port: 5", "listen: 127.0.0.1, tcp_port: 5"), "server.listen_twice tcp_port=5"},
        {two("listen: 0.0.0.0", "listen: 127.0.0.1"), "server.listen_twice listen=127.0.0.1"},
        {two("listen: ::1", "listen: 0:0::1"), "server.listen_twice listen=0:0::1"},
        {two("listen: ::", "listen: 127.0.0.1"), ""},
        {two("listen: 127.0.0.1", "listen: 127.0.0.2"), ""},
        {two("listen: *, tcp_port: 5", "listen: *, tcp_port: 6"), ""},
        {two("transport: serial, port: p", "transport: serial, port: p"), "line.port_twice port=p"},
        {two("listen: x, max_per_peer: 9, max_connections: 8",
             "listen: y, max_per_peer: 8, max_connections: 8"),
         "?field.without_effect max_per_peer=9"},
        {two("transport: serial, port: p, byte_timeout: 40ms, frame_timeout: 3s", "listen: x"), ""},
        {two("transport: serial, port: p, byte_timeout: 0ms", "listen: x"),
         "field.out_of_range byte_timeout=0ms [1ms..65535ms]"},
        {two("transport: serial, port: p, baud: 9600, byte_timeout: 1ms", "listen: x"),
         "field.out_of_range byte_timeout=1ms [5ms..65535ms]"},
        {two("transport: serial, port: p, baud: 9600, framing: ascii, byte_timeout: 1ms", "listen: x"), ""},
        {two("transport: serial, port: p, baud: 9600, frame_timeout: 1ms", "listen: x"),
         "field.out_of_range frame_timeout=1ms [294ms..24h]"},
        {two("transport: serial, port: p, baud: 9600, frame_timeout: 294ms", "listen: x"), ""},
        {two("transport: serial, port: p, frame_timeout: 25h", "listen: x"),
         "field.out_of_range frame_timeout=25h [1ms..24h]"},
        {two("listen: y, frame_timeout: 1ms", "listen: x"), ""},
        {two("transport: serial, port: p, strict: true, byte_timeout: 40ms", "listen: x"),
         "?field.without_effect byte_timeout=40ms"},
        {two("listen: y, byte_timeout: 40ms", "listen: x"), "?field.without_effect byte_timeout=40ms"},
        {two("transport: serial, port: p, framing: ascii, strict: true", "listen: x"),
         "?field.without_effect strict=true"},
        {bank("coil, items: [0..7], read_only: [3, 7..8]"), "bank.read_only_outside read_only= [0..7]"},
        {bank("coil, items: [0..7], overlay: holding_register"), "bank.missing banks=0"},
        {bank("coil, items: [0..32], overlay: holding_register, overlay_register: 4}, {area: "
              "holding_register, items: [0..5]"),
         "bank.overlay_outside banks=4 [0..5]"},
        {bank("coil, items: [0..31], overlay: holding_register, overlay_register: 4}, {area: "
              "holding_register, items: [0..5]"),
         ""},
        {bank("input_register, items: [0..7], retain: true"), "?field.without_effect banks="},
        {bank("input_register, items: [0..7], retain: true}, {area: coil, items: [0..7], overlay: "
              "input_register"),
         ""},
        {bank("discrete_input, items: [0..7], retain: true"), "?field.without_effect banks="},
        {unit("limits: [{registers: [1], least: 1, greatest: 4}, {registers: [5], least: 5, greatest: 6}]"),
         ""},
        {unit(
             "limits: [{registers: [1..3], least: 1, greatest: 4}, {registers: [3], least: 4, greatest: 6}]"),
         ""},
        {unit(
             "limits: [{registers: [1..3], least: 1, greatest: 4}, {registers: [3], least: 5, greatest: 6}]"),
         "limits.contradictory limits=5..6"},
        {unit("limits: [{registers: [3], least: -9, greatest: -2}, {registers: [3], least: 65533, greatest: "
              "65534}]"),
         ""},
        {unit("limits: [{registers: [9..10], least: 1, greatest: 4}]"),
         "limits.outside limits=9 [0..9, 20..29]"},
        {unit("limits: [{registers: [0..2], least: 1, greatest: 4}], variables: [{name: A, type: int, "
              "register: "
              "0, area: holding_register, default: 5}, {name: B, type: int, register: 1, area: "
              "holding_register, default: 4}, {name: C, type: int, register: 2, area: holding_register, "
              "scale: "
              "0.1, default: 0.5}, {name: D, type: int, register: 3, area: holding_register, default: 5}]"),
         "?variable.default_limits default=5 [1..4]; ?variable.default_limits default=0.5 [1..4]"},
        {unit("variables: [{name: A, type: float, register: 0, area: holding_register, source: {constant: "
              "1}}, "
              "{name: B, type: int, register: 1, area: holding_register, source: {constant: 2}}, {name: C, "
              "type: int, register: 2, area: holding_register, source: {constant: 2}}, {name: D, type: int, "
              "register: 2, area: holding_register}]"),
         "?variable.bound_twice variables[1]=B; ?variable.overlap variables[3]=D"},
        {unit("variables: [{name: A, type: float, register: 0, area: holding_register}, {name: B, type: int, "
              "register: 1, area: holding_register}, {name: C, type: int, register: 2, area: "
              "holding_register}]"),
         "?variable.overlap variables[1]=B"},
        {unit(
             "variables: [{name: A, type: int, register: 1, area: holding_register}, {name: B, type: double, "
             "register: 0, area: holding_register}, {name: C, type: int, register: 3, area: "
             "holding_register, used: false}, {name: D, type: int, register: 3, area: holding_register}]"),
         "?variable.overlap variables[1]=B; ?variable.overlap variables[3]=D"},
        {unit(
             "variables: [{name: A, type: int, register: 0, area: holding_register}, {name: B, type: bool, "
             "register: 0, bit: 1, area: holding_register}, {name: C, type: bool, register: 0, bit: 2, area: "
             "holding_register}, {name: D, type: bool, register: 0, bit: 2, area: holding_register}]"),
         "?variable.overlap variables[3]=D"},
        {unit("variables: [{name: A, type: bool, coil: 17, area: coil}, {name: B, type: bool, register: 1, "
              "bit: 1, area: coil}, {name: C, type: bool, register: 1, bit: 2, area: coil}]"),
         "?variable.overlap variables[1]=B"},
        {unit("variables: [{name: A, type: bool, register: 0, bit: 1, area: holding_register, source: "
              "{constant: true}}, {name: B, type: bool, register: 0, bit: 2, area: holding_register, source: "
              "{constant: true}}]"),
         ""},
        {unit("variables: [{name: A, type: int, register: 1, area: input_register}]"),
         "bank.missing variables[0]=1"},
        {unit(
             "variables: [{name: A, type: int, register: 1, area: holding_register, source: {variable: X}}]"),
         "name.none variable=X"},
        {unit("variables: [{name: A, type: int, register: 1, area: holding_register, source: {instrument: "
              "X.y}}]"),
         "name.none instrument=X.y"},
        {unit("variables: [{name: A, type: int, register: 1, area: holding_register, source: {local: X}}]"),
         "name.none local=X"},
        {unit(
             "variables: [{name: A, type: int, register: 1, area: holding_register, source: {counter: {from: "
             "10, to: 0.5}}}]"),
         "field.out_of_range to=0.5 [> 10]"},
        {unit("durability: none, state: x"),
         "?field.without_effect durability=none; "
         "?field.without_effect state=x"},
        {unit("limits: [{registers: [1], least: 5, greatest: 4}]"), "limits.reversed greatest=4 [5..65535]"},
        {unit("limits: [{registers: [1], least: -1, greatest: 40000}]"),
         "limits.reversed greatest=40000 [-1..32767]"},
        {unit("files: [{number: 1, records: 1}, {number: 1, records: 2}]"), "number.twice number=1"},
        {unit("files: [{number: 0, records: 1}]"), "field.out_of_range number=0 [1..65535]"},
        {unit("identification: [{id: 1, text: a}, {id: 1, text: b}]"), "number.twice id=1"},
        {unit("fifos: [{register: 1, values: [65536]}]"), "field.out_of_range values[0]=65536 [0..65535]"},
        {unit("fifos: [{register: 1, values: "
              "[1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1]}]"),
         "fifo.too_long values= [0..31]"},
        {unit("variables: [{name: A, type: float, register: 9, area: holding_register}]"),
         "variable.outside_bank variables[0]=9 [0..9, 20..29]"},
        {unit("variables: [{name: A, type: int, register: 9, area: holding_register, period: 1s}]"),
         "?field.without_effect period=1s"},
    };
    for (const auto& [servers, expected] : rows) EXPECT_EQ(findings_text(servers), expected) << servers;
}

TEST(Access, AWholeRule) {
    const auto checked = read(
        "{name: S, listen: x, audit: a.log, access: [{peers: [192.0.2.0/24, 2001:db8::/32, serial], units: "
        "[1, 3..5], "
        "functions: [read, 0x10], area: holding_register, items: [0..9, 20], rule: read_only, rate: 10, "
        "burst: "
        "20}, {rule: deny}], units: [{address: 1, banks: []}]}");
    ASSERT_TRUE(checked.findings.empty()) << checked.findings.front().code << checked.findings.front().path;
    const Server& server = checked.project.servers.at(0);
    EXPECT_EQ(server.audit, "a.log");
    ASSERT_EQ(server.access.size(), 2u);
    const AccessRule& rule = server.access[0];
    const std::vector<Network> networks{*parse_network("192.0.2.0/24"), *parse_network("2001:db8::/32")};
    EXPECT_EQ(rule.networks, networks);
    EXPECT_TRUE(rule.serial && !rule.every_peer && !rule.every_function);
    const std::vector<ItemRange> units{{1, 1}, {3, 5}};
    EXPECT_EQ(rule.units, units);
    EXPECT_EQ(rule.functions, (std::vector<std::uint8_t>{1, 2, 3, 4, 7, 11, 12, 17, 20, 24, 16}));
    EXPECT_TRUE(rule.identification);
    EXPECT_FALSE(rule.other_encapsulated);
    EXPECT_EQ(rule.area, wire::Area::holding_register);
    const std::vector<ItemRange> items{{0, 9}, {20, 20}};
    EXPECT_EQ(rule.items, items);
    EXPECT_EQ(rule.permission, AccessPermission::read_only);
    ASSERT_TRUE(rule.rate);
    EXPECT_EQ(rule.rate->per_second, 10u);
    EXPECT_EQ(rule.rate->burst, 20u);
    EXPECT_TRUE(server.access[1].every_peer && server.access[1].every_function);
    EXPECT_EQ(server.access[1].permission, AccessPermission::deny);
    EXPECT_FALSE(server.access[1].area || server.access[1].rate);
}

TEST(Access, EveryMistakeIsReported) {
    const auto rules = [](const std::string& list) {
        return findings_text("{name: S, listen: x, access: " + list + ", units: [{address: 1, banks: []}]}");
    };
    EXPECT_EQ(rules("[]"), "field.empty access=");
    EXPECT_EQ(rules("[{peers: [1.2.3, 10.0.0.0/33, eth0]}]"),
              "field.missing rule= [allow, read_only, deny]; peer.malformed peers[0]=1.2.3 [192.0.2.0/24, "
              "2001:db8::/32, serial]; "
              "peer.malformed peers[1]=10.0.0.0/33 [192.0.2.0/24, 2001:db8::/32, serial]; "
              "peer.malformed peers[2]=eth0 [192.0.2.0/24, 2001:db8::/32, serial]");
    EXPECT_EQ(rules("[{rule: deny, functions: [0, 128, all]}]"),
              "field.out_of_range functions[0]=0 [read, write, 1..127]; "
              "field.out_of_range functions[1]=128 [read, write, 1..127]; "
              "field.unknown_word functions[2]=all [read, write, 1..127]");
    EXPECT_EQ(rules("[{rule: deny, rate: 5}]"), "?field.without_effect rate=5");
    EXPECT_EQ(rules("[{rule: deny, peers: []}]"), "field.empty peers=");
    EXPECT_EQ(rules("[{rule: deny, items: [5]}]"), "field.missing area=");
    EXPECT_EQ(rules("[{rule: deny, units: [250..256]}]"), "field.out_of_range units=256 [0..255]");
    EXPECT_EQ(rules("[{rule: maybe}]"), "field.unlike_word rule=maybe [allow, read_only, deny]");
    EXPECT_EQ(rules("[{rule: deny, rate: 0}]"), "field.out_of_range rate=0 [1..1000000]");
    EXPECT_EQ(rules("[{rule: deny, burst: 3}]"), "?field.without_effect burst=3");
    EXPECT_EQ(rules("[5]"), "field.not_a_mapping access[0]=5");
}

TEST(Servers, AProjectNeedsLinesOrServers) {
    const auto checked = interpret(document({.project = "{lines: ~, locals: ~}"}));
    ASSERT_EQ(checked.findings.size(), 1u);
    EXPECT_EQ(checked.findings[0].code, "field.missing");
    EXPECT_EQ(checked.findings[0].path, "lines");
}

}  // namespace server_test
}  // namespace takt::model::test
