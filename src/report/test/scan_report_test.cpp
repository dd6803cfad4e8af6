#include "takt/report/states/scan_report.hpp"

#include <gtest/gtest.h>

#include "sample.hpp"

namespace takt::report {
namespace scan_report_test {

using namespace test;
using namespace std::chrono_literals;
using bus::FoundDevice;
using bus::ScanFindings;
using bus::ScanTrouble;

model::Line serial_line(std::uint32_t baud = 9600) {
    model::Line line;
    line.name = line.port = "/dev/ttyUSB0";
    line.format = {.baud = baud, .data_bits = 8, .parity = wire::Parity::none, .stop_bits = 1};
    return line;
}

model::Line tcp_line(const char* host) {
    model::Line line;
    line.transport = model::Transport::tcp;
    line.framing = wire::Framing::tcp;
    line.port = host;
    return line;
}

FoundDevice device(model::Line line, std::uint8_t unit) {
    return {std::move(line), {.unit = UnitId{unit}, .function = 3, .response_time = 12345us}};
}

bus::UnitIdentity identity(std::vector<std::pair<std::uint8_t, std::string>> objects) {
    bus::UnitIdentity made;
    for (auto& [id, text] : objects) made.objects.push_back({id, std::move(text)});
    return made;
}

std::vector<std::uint8_t> bytes(std::string_view text) {
    return {text.begin(), text.end()};
}

TEST(ScanReport, IdentitiesInAFewWords) {
    const struct {
        bus::UnitIdentity identity;
        const char* text;
    } cases[] = {
        {{}, ""},
        {identity({{0, "ACME"}, {1, "T1"}, {2, "1.0"}}), "ACME T1 1.0"},
        {identity({{0, "ACME"}, {4, "ACME"}, {1, "AC"}, {2, "2.1"}}), "ACME 2.1"},
        {identity({{3, "http://acme"}, {6, "app"}}), ""},
        {identity({{0, "a\x01\xFFz  "}}), "a..z"},
        {{.objects = {},
          .server_id = bytes("\x01\xFF"
                             "Boiler 5\x7F")},
         "Boiler 5"},
        {{.objects = {}, .server_id = {0x01, 0xFF}}, "01 FF"},
    };
    for (const auto& [identity, text] : cases) EXPECT_EQ(identity_text(identity), text);
    EXPECT_EQ(identity_text(identity({{0, std::string(500, 'x')}})).size(), 40U);
}

TEST(ScanReport, ADeviceInOneLine) {
    auto found = device(serial_line(), 16);
    EXPECT_EQ(device_line(english(), found),
              "rtu:///dev/ttyUSB0?baud=9600&parity=none&stop_bits=1 --unit 16  12.3 ms");
    found.unit.exception = 2;
    found.unit.late = found.unit.doubled = found.unit.garbled = true;
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto line = device_line(texts, found);
        expect_complete(line);
        expect_contains(line, texts("app.scan.exception", {{"code", "2"}}));
        expect_contains(line, texts("app.scan.doubled") + "; " + texts("app.scan.some_garbled") + "; " +
                                  texts("app.scan.late"));
    }
}

TEST(ScanReport, TroublesInEveryLanguage) {
    const auto error = fail(Code::cannot_open, "/dev/ttyUSB0", 13).error();
    for (const auto language : kLanguages) {
        const Texts texts(language);
        EXPECT_EQ(trouble_line(texts, {ScanTrouble::Kind::error, serial_line(), error, 0}),
                  texts.describe(error));
        for (const auto kind :
             {ScanTrouble::Kind::garbled, ScanTrouble::Kind::busy, ScanTrouble::Kind::foreign_master}) {
            const auto line = trouble_line(texts, {kind, tcp_line("::1"), {}, 7});
            expect_complete(line);
            expect_contains(line, "tcp://[::1]:502");
        }
    }
}

TEST(ScanReport, JsonOfDevices) {
    ScanFindings findings;
    findings.devices = {device(serial_line(), 16), device(tcp_line("host"), 1)};
    auto& unit = findings.devices[0].unit;
    unit.exception = 2;
    unit.identity = identity({{0, "ACME\n\""}, {2, "1.0"}});
    unit.identity.server_id = {0x11, 0xFF};
    const auto json = scan_json(english(), findings);
    const auto& serial = at(json, "devices", 0);
    EXPECT_JSON(at(serial, "target"), "rtu:///dev/ttyUSB0?baud=9600&parity=none&stop_bits=1");
    EXPECT_JSON(at(serial, "unit"), 16U);
    EXPECT_JSON(at(serial, "framing"), "rtu");
    EXPECT_JSON(at(serial, "baud"), 9600U);
    EXPECT_JSON(at(serial, "parity"), "none");
    EXPECT_JSON(at(serial, "exception"), 2U);
    EXPECT_JSON(at(serial, "response_ms"), 12.345);
    EXPECT_JSON(at(serial, "vendor"), "ACME.\"");
    EXPECT_JSON(at(serial, "product"), file::Json());
    EXPECT_JSON(at(serial, "server_id"), "11 FF");
    const auto& network = at(json, "devices", 1);
    for (const char* key : {"baud", "parity", "stop_bits", "exception", "server_id"})
        EXPECT_JSON(at(network, key), file::Json()) << key;
}

TEST(ScanReport, JsonOfTroublesAndTotals) {
    ScanFindings findings;
    const auto error = fail(Code::busy, "/dev/ttyUSB0").error();
    findings.troubles = {{ScanTrouble::Kind::error, serial_line(), error, 0},
                         {ScanTrouble::Kind::garbled, serial_line(), {}, 7}};
    findings.requests = 494;
    findings.absent_hosts = 3;
    findings.duration = 1500ms;
    findings.complete = true;
    const auto json = scan_json(english(), findings);
    EXPECT_JSON(at(json, "troubles", 0, "kind"), "error");
    EXPECT_JSON(at(json, "troubles", 0, "code"), name(Code::busy));
    EXPECT_JSON(at(json, "troubles", 0, "unit"), file::Json());
    EXPECT_JSON(at(json, "troubles", 1, "kind"), "garbled");
    EXPECT_JSON(at(json, "troubles", 1, "unit"), 7U);
    EXPECT_JSON(at(json, "requests"), 494U);
    EXPECT_JSON(at(json, "absent_hosts"), 3U);
    EXPECT_JSON(at(json, "duration_ms"), 1500);
    EXPECT_JSON(at(json, "complete"), true);
    EXPECT_EQ(
        scan_json(english(), {}).dump(),
        R"({"devices":[],"troubles":[],"absent_hosts":0,"requests":0,"duration_ms":0,"complete":false})");
}

TEST(ScanReport, TheProjectIsReadWithoutFindings) {
    ScanFindings findings;
    findings.devices = {device(serial_line(), 1), device(serial_line(), 2), device(serial_line(19200), 3),
                        device(tcp_line("10.0.0.7"), 1)};
    findings.devices[0].unit.identity = identity({{0, "AC\"ME\\"}});
    findings.devices[1].unit.response_time = 300ms;
    findings.devices[3].unit.function = 1;
    for (const auto language : kLanguages) {
        const auto yaml = scan_project(Texts(language), findings);
        expect_contains(yaml, "# rtu:///dev/ttyUSB0?baud=19200&parity=none&stop_bits=1 --unit 3");
        const auto project = project_of(yaml);
        ASSERT_EQ(project.lines.size(), 2U);
        const auto& line = project.lines[0];
        EXPECT_EQ(line.port, "/dev/ttyUSB0");
        EXPECT_EQ(line.format.baud, 9600U);
        ASSERT_EQ(line.devices.size(), 2U);
        EXPECT_EQ(line.devices[0].comment, "AC\"ME\\");
        EXPECT_EQ(line.devices[0].response_timeout, 500ms);
        EXPECT_EQ(line.devices[1].response_timeout, 900ms);
        EXPECT_EQ(line.devices[1].variables[0].name, "line1_unit2_holding_0");
        const auto& network = project.lines[1];
        EXPECT_EQ(network.transport, model::Transport::tcp);
        EXPECT_EQ(network.port, "10.0.0.7");
        EXPECT_EQ(network.devices[0].variables[0].area, wire::Area::coil);
    }
}

TEST(ScanReport, TheProjectHasTheRangesOfTheProbe) {
    ScanFindings findings;
    findings.devices = {device(tcp_line("h"), 1), device(tcp_line("h"), 255)};
    bus::ProbeFindings probe;
    probe.areas.resize(2);
    probe.areas[0].result.readable = {{0, 79}, {100, 100}};
    probe.areas[0].result.longest = 80;
    probe.areas[1].area = wire::Area::discrete_input;
    probe.areas[1].result.readable = {{5, 6}};
    const auto yaml = scan_project(english(), findings, {{findings.devices.data(), probe}});
    expect_contains(yaml, "# tcp://h:502 --unit 255");
    const auto project = project_of(yaml);
    ASSERT_EQ(project.lines[0].devices.size(), 1U);
    const auto& device = project.lines[0].devices[0];
    EXPECT_EQ(device.readable[static_cast<std::size_t>(wire::Area::holding_register)],
              (std::vector<model::ItemRange>{{0, 79}, {100, 100}}));
    EXPECT_FALSE(device.registers_per_request_set);
    EXPECT_EQ(device.variables.size(), 64U);

    probe.areas[0].result.readable = {{0, 0}};
    probe.areas[0].result.longest = 1;
    probe.areas[0].result.limited = true;
    const auto single = project_of(scan_project(english(), findings, {{findings.devices.data(), probe}}));
    EXPECT_FALSE(single.lines[0].devices[0].group_requests);
    EXPECT_EQ(single.lines[0].devices[0].variables.at(1).area, wire::Area::discrete_input);
    EXPECT_EQ(single.lines[0].devices[0].variables.at(1).start(), 5);
}

TEST(ScanReport, AProjectOfExceptionsHasNoVariables) {
    ScanFindings findings;
    findings.devices = {device(tcp_line("host"), 255)};
    findings.devices[0].unit.exception = 2;
    expect_contains(scan_project(english(), findings), "variables: []");
}

TEST(ScanReport, SummaryAndProgress) {
    ScanFindings findings;
    findings.duration = 125s;
    findings.requests = 7;
    findings.devices = {device(serial_line(), 1)};
    for (const auto language : kLanguages) {
        const Texts texts(language);
        findings.complete = true;
        findings.absent_hosts = 0;
        EXPECT_EQ(
            scan_summary(texts, findings),
            texts("app.scan.summary", {{"count", "1"}, {"requests", "7"}, {"time", texts.duration(125s)}}) +
                '\n');
        findings.complete = false;
        findings.absent_hosts = 4;
        const auto text = scan_summary(texts, findings);
        EXPECT_EQ(count_of(text, "\n"), 3U);
        expect_complete(text);
    }
}

TEST(ScanReport, ProgressNamesTheLineAndItsSetting) {
    struct : bus::ScanObserver {
        void on_device(const FoundDevice&) override {}
        void on_trouble(const ScanTrouble&) override {}
        void on_absent_host() override {}
    } observer;
    const bus::TargetScan port({{serial_line(), serial_line(19200)}, false}, {}, observer);
    EXPECT_EQ(scan_progress(english(), port, {}),
              "/dev/ttyUSB0 9600 8N1 (1/2), " + english()("app.scan.found", {{"count", "0"}}));
    const bus::TargetScan host({{tcp_line("host")}, false}, {}, observer);
    EXPECT_TRUE(scan_progress(english(), host, {}).starts_with("host:502, "));
}

}  // namespace scan_report_test
}  // namespace takt::report
