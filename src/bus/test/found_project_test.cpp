// The project of a scan: a line for each port or host, with the settings that most of its devices have in
// common.
#include "takt/bus/found_project.hpp"

#include <gtest/gtest.h>

namespace takt::bus {
namespace found_project_test {

using namespace std::chrono_literals;

model::Line serial_line(const char* port, std::uint32_t baud) {
    model::Line line;
    line.port = port;
    line.format.baud = baud;
    return line;
}

model::Line tcp_line(const char* host) {
    model::Line line;
    line.transport = model::Transport::tcp;
    line.framing = wire::Framing::tcp;
    line.port = host;
    return line;
}

FoundDevice device(model::Line line, std::uint8_t unit, Duration response_time = 10ms,
                   std::uint8_t function = 3, std::uint8_t exception = 0) {
    return {
        std::move(line),
        {.unit = UnitId{unit}, .function = function, .exception = exception, .response_time = response_time}};
}

ScanFindings findings_of(std::vector<FoundDevice> devices) {
    ScanFindings findings;
    findings.devices = std::move(devices);
    return findings;
}

TEST(FoundProject, NothingFoundIsAnEmptyProject) {
    const ScanFindings findings;
    EXPECT_TRUE(found_project(findings).lines.empty());
    EXPECT_TRUE(found_project(findings).others.empty());
}

TEST(FoundProject, ALineForEachHostTheLargestFirst) {
    const auto findings = findings_of({device(tcp_line("a"), 1), device(tcp_line("b"), 1),
                                       device(tcp_line("b"), 2), device(tcp_line("c"), 9)});
    const auto project = found_project(findings);
    ASSERT_EQ(project.lines.size(), 3U);
    EXPECT_EQ(project.lines[0].line.port, "b");
    EXPECT_EQ(project.lines[0].line.name, "line 1");
    ASSERT_EQ(project.lines[0].line.devices.size(), 2U);
    EXPECT_EQ(project.lines[0].line.devices[1].name, "unit 2");
    EXPECT_EQ(project.lines[0].line.devices[1].address, UnitId{2});
    EXPECT_EQ(project.lines[0].found[1], &findings.devices[2]);
    EXPECT_EQ(project.lines[1].line.port, "a") << "equal ones in the order they were found";
    EXPECT_EQ(project.lines[2].line.port, "c");
}

TEST(FoundProject, APortHasTheSettingsOfMostOfItsDevices) {
    const auto findings = findings_of(
        {device(serial_line("/dev/ttyS0", 9600), 1), device(serial_line("/dev/ttyS0", 19200), 2),
         device(serial_line("/dev/ttyS0", 19200), 3), device(serial_line("/dev/ttyS1", 9600), 1)});
    const auto project = found_project(findings);
    ASSERT_EQ(project.lines.size(), 2U);
    EXPECT_EQ(project.lines[0].line.format.baud, 19200U);
    EXPECT_EQ(project.lines[1].line.port, "/dev/ttyS1");
    ASSERT_EQ(project.others.size(), 1U);
    EXPECT_EQ(project.others[0], &findings.devices[0]);
}

TEST(FoundProject, TheTimeOutFollowsASlowResponse) {
    const Duration standard = 500ms;
    const struct {
        Duration response_time;
        Duration timeout;
    } cases[] = {{0ms, standard}, {249ms, standard},   {249999us, standard}, {250ms, 750ms},
                 {400ms, 1200ms}, {1234567us, 3702ms}, {30s, 65535ms}};
    for (const auto& [response_time, timeout] : cases) {
        const auto findings = findings_of({device(tcp_line("a"), 1, response_time)});
        EXPECT_EQ(found_project(findings).lines[0].line.devices[0].response_timeout, timeout)
            << response_time.count();
    }
}

TEST(FoundProject, AVariableWhereItemZeroWasRead) {
    const struct {
        std::uint8_t function;
        std::uint8_t exception;
        const char* name;
        wire::Area area;
        DataType type;
    } cases[] = {
        {3, 0, "line1_unit7_holding_0", wire::Area::holding_register, DataType::uint16},
        {4, 0, "line1_unit7_input_0", wire::Area::input_register, DataType::uint16},
        {1, 0, "line1_unit7_coil_0", wire::Area::coil, DataType::boolean},
        {3, 2, "", {}, {}},
        {43, 0, "", {}, {}},
    };
    for (const auto& c : cases) {
        const auto findings = findings_of({device(tcp_line("a"), 7, 1ms, c.function, c.exception)});
        const auto made = found_project(findings);
        const auto& variables = made.lines[0].line.devices[0].variables;
        if (*c.name == '\0') {
            EXPECT_TRUE(variables.empty());
            continue;
        }
        ASSERT_EQ(variables.size(), 1U);
        EXPECT_EQ(variables[0].name, c.name);
        EXPECT_EQ(variables[0].area, c.area);
        EXPECT_EQ(variables[0].type, c.type);
        EXPECT_EQ(variables[0].start(), 0U);
        EXPECT_EQ(static_cast<int>(*variables[0].read), c.function);
    }
}

TEST(FoundProject, UnitsOfTheHostAreNoFurtherDevices) {
    auto other = device(tcp_line("b"), 255);
    other.unit.identity.objects = {{0, "gateway"}};
    const auto findings =
        findings_of({device(tcp_line("a"), 1), device(tcp_line("a"), 0), device(tcp_line("a"), 255), other,
                     device(tcp_line("b"), 3), device(tcp_line("c"), 0), device(tcp_line("c"), 255)});
    const auto project = found_project(findings);
    ASSERT_EQ(project.lines.size(), 3U);
    EXPECT_EQ(project.lines[0].line.port, "b");
    EXPECT_EQ(project.lines[0].line.devices.size(), 2U) << "the gateway itself is another device";
    ASSERT_EQ(project.lines[1].line.devices.size(), 1U);
    EXPECT_EQ(project.lines[1].line.devices[0].address, UnitId{1});
    ASSERT_EQ(project.lines[2].line.devices.size(), 1U);
    EXPECT_EQ(project.lines[2].line.devices[0].address, UnitId{255});
    EXPECT_EQ(project.same, (std::vector{&findings.devices[1], &findings.devices[2], &findings.devices[5]}));
}

TEST(FoundProject, VariablesOfAProbedDevice) {
    const auto findings = findings_of({device(tcp_line("a"), 7)});
    ProbeFindings probe;
    probe.areas.resize(2);
    probe.areas[0].result.readable = {{3, 4}};
    probe.areas[1].area = wire::Area::discrete_input;
    probe.areas[1].result.readable = {{17, 500}};
    const auto made = found_project(findings, {{findings.devices.data(), probe}});
    const auto& variables = made.lines[0].line.devices[0].variables;
    ASSERT_EQ(variables.size(), kMostFoundVariables);
    EXPECT_EQ(variables[1].name, "line1_unit7_holding_4");
    EXPECT_EQ(variables[1].start(), 4U);
    EXPECT_EQ(variables[2].name, "line1_unit7_discrete_17");
    EXPECT_EQ(variables[2].start(), 17U);
    EXPECT_EQ(variables[2].type, DataType::boolean);
    EXPECT_EQ(variables[2].read, wire::Function::read_discrete_inputs);
}

TEST(FoundProject, ManyHosts) {
    std::vector<FoundDevice> devices;
    for (int i = 0; i < 2000; ++i) devices.push_back(device(tcp_line(std::to_string(i).c_str()), 1));
    const auto findings = findings_of(std::move(devices));
    EXPECT_EQ(found_project(findings).lines.size(), 2000U);
}

}  // namespace found_project_test
}  // namespace takt::bus
