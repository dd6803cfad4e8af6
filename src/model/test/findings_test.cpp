#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "flow.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/findings.hpp"

namespace takt::model::test {
namespace findings_test {

/// "code path line:column" of each finding; a warning's code behind '?'.
std::vector<std::string> located(const Checked& checked) {
    std::vector<std::string> all;
    for (const auto& [severity, code, location, path, value, allowed, arguments] : checked.findings)
        all.push_back((severity == Severity::warning ? "?" : "") + code + " " + path + " " +
                      std::to_string(location.line) + ":" + std::to_string(location.column));
    return all;
}

std::string argument(const Finding& finding, std::string_view name) {
    for (const auto& [key, text] : finding.arguments)
        if (key == name) return text;
    return "?";
}

Checked check(std::string_view text) {
    return interpret({{"project.yaml", "table.csv"}, flow(text)});
}

/// A device of a list, with one variable of its own.
std::string device(int index, int address, int variables = 1) {
    std::string text = "{name: D, address: " + std::to_string(address) + ", variables: [";
    for (int i = 0; i < variables; ++i)
        text += "{name: V" + std::to_string(index) + "." + std::to_string(i) +
                ", type: int, register: " + std::to_string(i) + ", read: 0x03},\n";
    return text + "]},\n";
}

std::string project(std::string_view profile, const std::string& devices) {
    return "{takt: 1, profile: " + std::string(profile) +
           ", lines: [{name: N, transport: serial, port: /dev/ttyS0, devices: [\n" + devices + "]}]}";
}

TEST(Findings, AllAtOnceInTheOrderOfTheirPlaces) {
    const auto checked = check(
        "{profile: genric,\n"
        " lines: [{nam: N, transport: serial, port: /dev/ttyS0, baud: 9600.5,\n"
        "  devices: [\n"
        "   {name: A, adress: 1,\n"
        "    poll_period: 100, status: gone, variables: [\n"
        "     {name: X, type: word, register: 65536, read: 0x03},\n"
        "     {name: X, type: int, register: 010, read: 0x07}]},\n"
        "   {name: B, address: 17, variables: [{name: Y, type: int, register: 1, read: 0x03}]}]}],\n"
        " locals: [{name: Y, type: int}]}");
    const std::vector<std::string> expected{
        "field.missing takt 1:1",
        "field.unknown_word profile 1:11",
        "key.unknown lines[0].nam 2:11",
        "integer.fraction lines[0].baud 2:62",
        "key.unknown lines[0].devices[0].adress 4:14",
        "duration.no_unit lines[0].devices[0].poll_period 5:18",
        "local.unknown lines[0].devices[0].status 5:31",
        "field.unknown_word lines[0].devices[0].variables[0].type 6:22",
        "field.out_of_range lines[0].devices[0].variables[0].register 6:38",
        "name.duplicate lines[0].devices[0].variables[1].name 7:13",
        "integer.leading_zero lines[0].devices[0].variables[1].register 7:37",
        "function.not_allowed lines[0].devices[0].variables[1].read 7:48",
        "name.duplicate lines[0].devices[1].variables[0].name 8:46",
    };
    EXPECT_EQ(located(checked), expected);
    EXPECT_TRUE(checked.has_errors());
    EXPECT_EQ(checked.project.lines.at(0).devices.at(1).variables.at(0).register_number, 1)
        << "the rest is read";
}

TEST(Findings, NameTheNearest) {
    struct Case {
        Changes changes;
        std::string_view nearest;
    };
    const Case cases[] = {
        {{.variable = "{regster: 1}"}, "register"},
        {{.variable = "{Register: 1}"}, "register"},
        {{.variable = "{write_on_chnage: true}"}, "write_on_change"},
        {{.variable = "{tpye: int}"}, "type"},
        {{.device = "{adress: 1}"}, "address"},
        {{.device = "{timeout: 1s}"}, "response_timeout"},
        {{.line = "{boud: 1}"}, "baud"},
        {{.line = "{parity: Even}"}, "even"},
        {{.variable = "{type: flaot}"}, "float"},
        {{.variable = "{status: stat}"}, "state"},
        {{.project = "{linse: []}"}, "lines"},
        {{.project = "{host: {jiter: 1ms}}"}, "jitter"},
        {{.project = "{backoff: {limits: 1s}}"}, "limit"},
        {{.project = "{servers: [{name: S, host: 0.0.0.0, units: [{address: 1, banks: []}]}]}"}, "listen"},
        {{.project =
              "{servers: [{name: S, listen: *, units: [{address: 1, banks: [{area: coil, start: 1}]}]}]}"},
         "items"},
        {{.line = "{connect: plc}"}, "host"},
        {{.variable = "{start: 0, register: ~}"}, "register"},
        {{.device = "{strategy: optimal, readable: {coils: [1]}}"}, "coil"},
        {{.device = "{strategy: optimal, write_single: onyl}"}, "only"},
    };
    for (const auto& [changes, nearest] : cases) {
        const auto checked = interpret(document(changes));
        ASSERT_FALSE(checked.findings.empty()) << nearest;
        EXPECT_EQ(argument(checked.findings[0], "nearest"), nearest);
    }
    EXPECT_EQ(interpret(document({.project = "{locals: []}", .device = "{status: s}"})).findings.at(0).code,
              "local.undeclared");
}

// One table of words serves every object: `connect` means the host of a line wherever it stands.
TEST(Findings, NameTheObjectOfAKey) {
    const auto in_server = [](const std::string& server, const std::string& unit = "",
                              const std::string& bank = "") {
        return "{servers: [{name: S, listen: *" + server + ", units: [{address: 1, banks: [{area: coil, " +
               "items: [0..9]" + bank + "}]" + unit + "}]}]}";
    };
    struct Case {
        std::string project = "{}";
        std::string line = "{}";
        std::string device = "{}";
        std::string variable = "{}";
        std::string_view location;
    };
    const Case cases[] = {
        {.device = "{baud: 9600}", .location = "lines[].baud"},
        {.device = "{speed: 9600}", .location = "lines[].baud"},
        {.device = "{host: plc}", .location = "lines[].host"},
        {.device = "{connect: tcp://plc}", .location = "lines[].host"},
        {.device = "{server: plc}", .location = "lines[].host"},
        {.device = "{url: tcp://plc}", .location = "lines[].host"},
        {.device = "{port: 502}", .location = "lines[].tcp_port"},
        {.device = "{port: /dev/ttyS1}", .location = "lines[].port"},
        {.line = "{slave: 3}", .location = "lines[].devices[].address"},
        {.line = "{unit: 3}", .location = "lines[].devices[].address"},
        {.line = "{unit: bar}", .location = "lines[].devices[].variables[].unit"},
        {.device = "{start: 0}", .location = "lines[].devices[].variables[].register"},
        {.device = "{listen: 127.0.0.1}", .location = "servers[].listen"},
        {.variable = "{connect: plc}", .location = "lines[].host"},
        {.variable = "{host: plc}", .location = "lines[].host"},
        {.variable = "{listen: 127.0.0.1}", .location = "servers[].listen"},
        {.line = "{start: 0}", .location = "lines[].devices[].variables[].register"},
        {.line = "{listen: 127.0.0.1}", .location = "servers[].listen"},
        {.project = "{connect: plc}", .location = "lines[].host"},
        {.project = "{host: plc}", .location = "lines[].host"},
        {.project = "{listen: 127.0.0.1}", .location = "servers[].listen"},
        {.project = "{start: 0}", .location = "lines[].devices[].variables[].register"},
        {.project = "{start: [{write: abc}]}", .location = "instruments[].start"},
        {.project = "{locals: [{name: B, type: int, connect: plc}]}", .location = "lines[].host"},
        {.project = in_server(", connect: plc"), .location = "lines[].host"},
        {.project = in_server(", start: 0"), .location = "servers[].units[].banks[].items"},
        {.project = in_server("", ", connect: plc"), .location = "lines[].host"},
        {.project = in_server("", ", host: 127.0.0.1"), .location = "servers[].listen"},
        {.project = in_server("", ", listen: 127.0.0.1"), .location = "servers[].listen"},
        {.project = in_server("", ", start: 0"), .location = "servers[].units[].banks[].items"},
        {.project = in_server("", "", ", listen: 127.0.0.1"), .location = "servers[].listen"},
    };
    for (const auto& [project, line, device, variable, location] : cases) {
        const auto checked =
            interpret(document({.project = project, .line = line, .device = device, .variable = variable}));
        ASSERT_FALSE(checked.findings.empty()) << location;
        const auto& finding = checked.findings[0];
        EXPECT_EQ(finding.code, "key.elsewhere") << finding.path;
        EXPECT_EQ(argument(finding, "location"), location) << finding.path;
    }
}

TEST(Findings, PointToWhatWasThereFirst) {
    const auto checked = check(
        "{takt: 1, lines: [\n"
        " {name: N, port: /dev/ttyS0, devices: [{name: A, address: 1}, {name: A, address: 0x01}]},\n"
        " {name: N, port: /dev/ttyS0, devices: [{name: A, address: 1}]},\n"
        " {name: M, transport: tcp, host: dev-ttyS0, devices: [{name: A, address: 1}]}]}");
    const std::vector<std::string> expected{"address.duplicate lines[0].devices[1].address 2:82",
                                            "name.duplicate lines[1].name 3:9",
                                            "line.port_twice lines[1].port 3:18"};
    EXPECT_EQ(located(checked), expected);
    for (const auto& finding : checked.findings) EXPECT_EQ(argument(finding, "first"), "project.yaml:2");
}

TEST(Findings, CellsOfATableHaveNoTypes) {
    auto source = document({});
    const auto variable = [](std::string_view text) { return flow(text, 1); };
    auto& variables = source.root.entries[1].value.items[0].entries[3].value.items[0].entries[2].value;
    variables.items = {
        variable("{name: A, type: int, register: \"1\", read: \"0x03\", bit: , period: , write: }"),
        variable("{name: B, type: int, reference: 40001, read: \"3\"}"),
        variable("{name: C, type: bool, bit: \"1\", register: 5, used: \"FALSE\", read: 3}"),
        variable("{name: D, type: , register: 1, read: 3}")};
    const auto checked = interpret(source);
    const std::vector<std::string> expected{"field.missing lines[0].devices[0].variables[3].type 1:17"};
    EXPECT_EQ(located(checked), expected);
    EXPECT_EQ(checked.findings[0].location.file, 1U);
    EXPECT_FALSE(checked.project.lines[0].devices[0].variables[2].used);
}

TEST(Findings, AListHasOneWarningOfAddressesLikeReferences) {
    auto source = document({});
    auto& variables = source.root.entries[1].value.items[0].entries[3].value.items[0].entries[2].value;
    variables.items = {flow("{name: A, type: int, register: 40001, read: 3}"),
                       flow("{name: B, type: int, register: 40002}"),
                       flow("{name: C, type: int, register: 5, read: 3}"),
                       flow("{name: D, type: int, register: 40004, read: 4}")};
    const auto checked = interpret(source);
    ASSERT_EQ(checked.findings.size(), 2U) << "that of B without an area, and one for A and B";
    const auto& warning =
        checked.findings[0].code == "address.like_reference" ? checked.findings[0] : checked.findings[1];
    EXPECT_EQ(warning.path, "lines[0].devices[0].variables[0].register");
    EXPECT_EQ(warning.value, "40001");
    EXPECT_EQ(argument(warning, "area") + argument(warning, "number") + argument(warning, "wire") +
                  argument(warning, "count"),
              "holding_register00x9C412");
}

TEST(Findings, AnUnknownColumnIsSaidOnce) {
    auto source = document({});
    auto& variables = source.root.entries[1].value.items[0].entries[3].value.items[0].entries[2].value;
    const std::vector<std::string> header{"name", "type", "regster", "baud", "read"};
    const auto row = [&](const std::vector<std::string>& cells, std::uint32_t line) {
        Node node{.kind = Node::Kind::mapping, .location = {1, line, 1}};
        for (std::uint32_t i = 0; i < cells.size(); ++i)
            node.entries.emplace_back(
                Node{.kind = Node::Kind::scalar, .location = {1, 1, i + 1}, .text = header[i], .cell = true},
                Node{.kind = Node::Kind::scalar,
                     .location = {1, line, i + 1},
                     .text = cells[i],
                     .cell = true});
        return node;
    };
    variables.items = {row({"A", "int", "1", "9600", "3"}, 2), row({"B", "int", "2", "9600", "3"}, 3),
                       row({"C", "word", "3", "9600", "3"}, 4)};
    const std::vector<std::string> expected{"key.unknown lines[0].devices[0].variables[0].regster 1:3",
                                            "key.elsewhere lines[0].devices[0].variables[0].baud 1:4",
                                            "field.unknown_word lines[0].devices[0].variables[2].type 4:2"};
    EXPECT_EQ(located(interpret(source)), expected) << "and no address is missed in any row";
}

TEST(Findings, MoreThan32DevicesOnASegment) {
    std::string devices;
    for (int i = 0; i < 32; ++i) devices += device(i, i + 1);
    EXPECT_EQ(located(check(project("generic", devices))).size(), 0U);
    devices += device(32, 33);
    EXPECT_EQ(located(check(project("generic", devices))),
              std::vector<std::string>{"?line.many_devices lines[0].devices 1:37"});
}

TEST(Findings, WhatIsBeyondTheControllerIsLeftOut) {
    std::string devices;
    for (int i = 0; i < 34; ++i) devices += device(i, 34 - i, i == 33 ? 1000 : 1);
    const auto checked = check(project("owen-kc1", devices));
    const std::vector<std::string> expected{
        "?profile.too_many_devices lines[0].devices[0] 2:1",
        "?profile.too_many_devices lines[0].devices[1] 4:1",
        "?profile.too_many_variables lines[0].devices[8].variables[0] 18:33",
    };
    const auto found = located(checked);
    ASSERT_EQ(found.size(), 2U + 7U);
    EXPECT_EQ(found[0], expected[0]);
    EXPECT_EQ(found[1], expected[1]);
    const auto& kept = checked.project.lines[0].devices;
    ASSERT_EQ(kept.size(), 32U);
    EXPECT_EQ(kept.front().address, UnitId{32});
    EXPECT_EQ(kept.back().variables.size(), 1000U);
    std::size_t variables = 0;
    for (const auto& each : kept) variables += each.variables.size();
    EXPECT_EQ(variables, 1024U);
    EXPECT_FALSE(checked.has_errors());
}

TEST(Findings, AreBoundedAndErrorsGoFirst) {
    std::string devices;
    for (int i = 0; i < 700; ++i)
        devices += "{name: W, address: 1, attempts: 0, response_timeout: 0, turnaround: 1,},\n";
    const auto checked = check(project("generic", devices));
    ASSERT_EQ(checked.findings.size(), 1000U);
    const auto& last = checked.findings.back();
    EXPECT_EQ(last.code, "findings.more");
    EXPECT_EQ(last.severity, Severity::error);
    EXPECT_EQ(argument(last, "count"), std::to_string(699 + 700 + 1400 + 1 - 999));
    EXPECT_TRUE(
        std::ranges::is_sorted(checked.findings, {}, [](const Finding& f) { return f.location.line; }));
    EXPECT_EQ(std::ranges::count(checked.findings, Severity::error, &Finding::severity), 1000);
}

TEST(Findings, LongValuesAreCut) {
    const auto checked = interpret(document({.line = "{parity: " + std::string(500, 'x') + "}"}));
    EXPECT_EQ(checked.findings.at(0).value, std::string(200, 'x') + "…");
}

TEST(Findings, EveryCodeIsKnownAndDiffers) {
    const auto codes = finding_codes();
    EXPECT_EQ(std::set<std::string_view>(codes.begin(), codes.end()).size(), codes.size());
    EXPECT_TRUE(
        std::ranges::all_of(codes, [](auto code) { return code.find('.') != std::string_view::npos; }));
}

TEST(Fields, EachOneIsReadAndJudged) {
    const auto changes = [](Object object, std::string_view text) -> Changes {
        switch (object) {
            case Object::project: return {.project = text};
            case Object::line: return {.line = text};
            case Object::device: return {.device = text};
            case Object::variable: return {.variable = text};
            case Object::local: return {.local = text};
            default: return {};
        }
    };
    const auto wanted_of = [](Kind kind) {
        if (kind == Kind::list || kind == Kind::ranges) return "field.not_a_list";
        return kind == Kind::mapping ? "field.not_a_group" : "field.not_a_value";
    };
    const auto judge = [&](Object object, Object inside, std::string before, std::string_view after) {
        for (const auto& field : fields(inside)) {
            const bool many = field.kind == Kind::list || field.kind == Kind::ranges;
            const auto text =
                before + std::string(field.key) + (many ? ": 7}" : ": [7]}") + std::string(after);
            const auto checked = interpret(document(changes(object, text)));
            const auto* const wanted = wanted_of(field.kind);
            const auto about_it = [&](const Finding& finding) {
                return finding.code == wanted && finding.path.ends_with(field.key);
            };
            EXPECT_EQ(std::ranges::count_if(checked.findings, about_it), 1) << text;
        }
    };
    for (const auto object :
         {Object::project, Object::line, Object::device, Object::variable, Object::local}) {
        judge(object, object, "{", "");
        for (const auto& field : fields(object))
            if (field.object) judge(object, *field.object, "{" + std::string(field.key) + ": {", "}");
    }
}

TEST(Fields, RangesFollowTheContext) {
    const Context rtu{.profile = Profile::owen_kc1};
    const Context ascii{.profile = Profile::owen_kc1, .framing = wire::Framing::ascii};
    const Context tcp{.transport = Transport::tcp, .framing = wire::Framing::tcp};
    const auto* const registers = find_field(Object::device, "registers_per_request");
    const auto* const address = find_field(Object::device, "address");
    ASSERT_NE(registers, nullptr);
    ASSERT_NE(address, nullptr);
    EXPECT_EQ(allowed(*registers, rtu), "2..125");
    EXPECT_EQ(allowed(*registers, ascii), "2..125");  // more than 61 is cut
    EXPECT_EQ(allowed(*registers, {.framing = wire::Framing::ascii}), "2..125");
    EXPECT_EQ(allowed(*registers, tcp), "2..125");
    EXPECT_EQ(allowed(*address, rtu), "1..247");
    EXPECT_EQ(allowed(*address, tcp), "0..255");
    EXPECT_EQ(find_field(Object::local, "register"), nullptr);
}

}  // namespace findings_test
}  // namespace takt::model::test
