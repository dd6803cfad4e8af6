// Service variables: their table, their names in a project, and the findings of wrong ones.
#include "takt/model/service.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "flow.hpp"
#include "takt/model/findings.hpp"

namespace takt::model::test {
namespace service_test {

using namespace std::chrono_literals;

std::string findings_text(const Checked& checked) {
    std::string all;
    for (const auto& finding : checked.findings) {
        if (finding.severity == Severity::warning) continue;
        if (!all.empty()) all += "; ";
        all += finding.code + " " + finding.path.substr(finding.path.rfind('.') + 1) + "=" + finding.value;
    }
    return all;
}

Project two_lines() {
    Project project;
    const auto device = [](const char* name, std::uint8_t address) {
        Device made;
        made.name = name;
        made.address = UnitId{address};
        return made;
    };
    project.lines.resize(2);
    project.lines[0].name = "north";
    project.lines[0].devices = {device("Boiler", 1), device("Pump", 2), device("Twin", 3), device("Twin", 4)};
    project.lines[1].name = "south.2";
    project.lines[1].devices = {device("Pump", 2), device("Dr. Pump", 7), device("a/b", 8)};
    return project;
}

TEST(ServiceTable, EachNameIsUniqueInItsScope) {
    std::set<std::pair<ServiceScope, std::string_view>> seen;
    for (const auto& field : service_fields()) {
        EXPECT_TRUE(seen.emplace(field.scope, field.word).second) << field.word;
        EXPECT_EQ(field.word.find('.'), std::string_view::npos) << "the last dot ends the name before it";
        EXPECT_NE(field.type, DataType::string);
    }
}

struct NameCase {
    const char* name;
    const char* found;  // "line device word"; empty: unknown
};

class ServiceNamesTest : public ::testing::TestWithParam<NameCase> {};

TEST_P(ServiceNamesTest, Find) {
    const auto project = two_lines();
    const auto found = ServiceNames(project).find(GetParam().name);
    const auto text = found ? std::to_string(found->line) + " " + std::to_string(found->device) + " " +
                                  std::string(found->field->word)
                            : std::string();
    EXPECT_EQ(text, GetParam().found);
    if (!found) return;
    const ServiceNames names(project);
    const auto again = names.find(names.name(*found));
    ASSERT_TRUE(again) << names.name(*found);
    EXPECT_EQ(again->line, found->line);
    EXPECT_EQ(again->device, found->device);
    EXPECT_EQ(again->field, found->field);
}

INSTANTIATE_TEST_SUITE_P(
    Names, ServiceNamesTest,
    ::testing::Values(NameCase{"system.time", "0 0 time"}, NameCase{"system.line.north.load", "0 0 load"},
                      NameCase{"system.line.south.2.load", "1 0 load"},
                      NameCase{"system.device.Boiler.state", "0 0 state"},
                      NameCase{"system.device.Dr. Pump.state", "1 1 state"},
                      NameCase{"system.device.a/b.state", "1 2 state"},
                      NameCase{"system.device.south.2/a/b.state", "1 2 state"},
                      NameCase{"system.device.north/Pump.errors", "0 1 errors"},
                      NameCase{"system.device.south.2/Pump.errors", "1 0 errors"},
                      NameCase{"system.device.north/Boiler.errors", "0 0 errors"},
                      NameCase{"system.device.north/4.errors", "0 3 errors"},
                      NameCase{"system.device.Pump.errors", ""}, NameCase{"system.device.Twin.errors", ""},
                      NameCase{"system.device.north/Twin.errors", ""},
                      NameCase{"system.device.Boiler.load", ""}, NameCase{"system.device.Boiler", ""},
                      NameCase{"system.line.west.load", ""}, NameCase{"system.", ""},
                      NameCase{"system.Time", ""}, NameCase{"System.time", ""}, NameCase{"time", ""}));

TEST(ServiceNames, AHintNamesWhatExists) {
    const auto project = two_lines();
    const ServiceNames names(project);
    EXPECT_EQ(names.hint("system.tiem").nearest, "system.time");
    EXPECT_EQ(names.hint("system.tiem").allowed,
              "system.time, system.uptime, system.first_cycle, system.pulse_1s, system.pulse_1min, "
              "system.line.NAME.*, system.device.NAME.*");
    EXPECT_EQ(names.hint("system.line.nort.load").nearest, "system.line.north.load");
    EXPECT_EQ(names.hint("system.line.nort.load").allowed,
              "system.line.north.load, system.line.south.2.load");
    EXPECT_EQ(names.hint("system.line.north.lod").nearest, "system.line.north.load");
    EXPECT_EQ(names.hint("system.line.north.lod").allowed,
              "system.line.north.up, system.line.north.load, system.line.north.cycle, "
              "system.line.north.requests, system.line.north.errors");
    EXPECT_EQ(names.hint("system.device.Pump.errors").allowed,
              "system.device.Boiler.errors, system.device.north/Pump.errors, system.device.north/3.errors, "
              "system.device.north/4.errors, system.device.south.2/Pump.errors, "
              "system.device.Dr. Pump.errors, system.device.a/b.errors");
    const auto none = Project{};
    EXPECT_EQ(ServiceNames(none).hint("system.device.X.state").allowed, names.hint("system.tiem").allowed);
}

TEST(ServiceVariables, ATriggerBecomesALocalBehindTheOthers) {
    const auto checked = interpret(document({.variable = "{read_trigger: system.pulse_1s}"}));
    EXPECT_EQ(findings_text(checked), "");
    const auto& project = checked.project;
    const auto& variable = project.lines[0].devices[0].variables[0];
    ASSERT_TRUE(variable.read_trigger);
    EXPECT_EQ(*variable.read_trigger, project.locals.size() - 1);
    const auto& local = project.locals.back();
    EXPECT_EQ(local.name, "system.pulse_1s");
    EXPECT_TRUE(local.service);
    ASSERT_TRUE(local.admission) << "it bounds what the trigger costs";
    EXPECT_EQ(local.admission->min_interval, 900ms) << "less than the period: a late pulse delays no other";
}

TEST(ServiceVariables, TwoUsesShareOneLocal) {
    const auto checked = interpret(document({.line = "{name: L1}",
                                             .device = "{poll_enable: system.line.L1.up}",
                                             .variable = "{read_trigger: system.line.L1.up}"}));
    EXPECT_EQ(findings_text(checked), "");
    const auto& device = checked.project.lines[0].devices[0];
    EXPECT_EQ(device.poll_enable, device.variables[0].read_trigger);
}

struct MistakeCase {
    const char* description;
    Changes changes;
    const char* findings;
};

class ServiceMistakes : public ::testing::TestWithParam<MistakeCase> {};

TEST_P(ServiceMistakes, IsAFinding) {
    EXPECT_EQ(findings_text(interpret(document(GetParam().changes))), GetParam().findings)
        << GetParam().description;
}

INSTANTIATE_TEST_SUITE_P(All, ServiceMistakes,
                         ::testing::Values(MistakeCase{"no such word",
                                                       {.variable = "{read_trigger: system.pulse}"},
                                                       "service.unknown read_trigger=system.pulse"},
                                           MistakeCase{"a mistyped prefix",
                                                       {.variable = "{read_trigger: sytem.pulse_1s}"},
                                                       "service.unknown read_trigger=sytem.pulse_1s"},
                                           MistakeCase{"another name with a dot",
                                                       {.variable = "{read_trigger: pump.go}"},
                                                       "local.unknown read_trigger=pump.go"},
                                           MistakeCase{
                                               "no such device",
                                               {.variable = "{read_trigger: system.device.None.answering}"},
                                               "service.unknown read_trigger=system.device.None.answering"},
                                           MistakeCase{"a trigger is a bool",
                                                       {.variable = "{read_trigger: system.uptime}"},
                                                       "service.type read_trigger=system.uptime"},
                                           MistakeCase{"a status is written",
                                                       {.device = "{status: system.uptime}"},
                                                       "service.read_only status=system.uptime"},
                                           MistakeCase{"the name of a local",
                                                       {.local = "{name: system.mine}"},
                                                       "name.reserved name=system.mine"},
                                           MistakeCase{"the name of a variable",
                                                       {.variable = "{name: system.time}"},
                                                       "name.reserved name=system.time"}));

Checked served(const std::string& keys, const std::string& type = "uint32") {
    const std::string project =
        "{servers: [{name: S, listen: x, units: [{address: 1, banks: [{area: holding_register, items: "
        "[0..9]}], variables: [{name: A, area: holding_register, register: 2, type: " +
        type + ", " + keys + "}]}]}]}";
    return interpret(document({.project = project}));
}

TEST(ServiceVariables, AsTheSourceOfARegister) {
    for (const auto* key : {"variable", "local"}) {
        const auto checked = served("source: {" + std::string(key) + ": system.uptime}");
        EXPECT_EQ(findings_text(checked), "");
        const auto& binding = checked.project.servers.at(0).units.at(0).bindings.at(0);
        EXPECT_EQ(std::get<LocalSource>(*binding.source).name, "system.uptime");
        EXPECT_FALSE(binding.sink) << "read-only";
        EXPECT_FALSE(binding.max_age);
    }
    EXPECT_EQ(served("source: {variable: system.uptime}, max_age: 3s")
                  .project.servers.at(0)
                  .units.at(0)
                  .bindings.at(0)
                  .max_age,
              3s);
    EXPECT_EQ(findings_text(served("writes_to: {local: system.uptime}")),
              "service.read_only local=system.uptime");
    EXPECT_EQ(findings_text(served("writes_to: {variable: system.time}")),
              "service.read_only variable=system.time");
    for (const std::string key : {"variable", "local"})
        for (const std::string name : {"system.uptim", "Sytem.uptime"})
            EXPECT_EQ(findings_text(served("source: {" + key + ": " + name + "}")),
                      "service.unknown " + key + "=" + name);
    EXPECT_EQ(findings_text(served("source: {variable: system.uptime}", "string, length: 2")),
              "source.type variable=system.uptime");
}

struct EnableCase {
    const char* enables;   // of the devices A, B, C, D; "-": none
    const char* findings;  // the devices that wait for themselves
};

class ServiceEnables : public ::testing::TestWithParam<EnableCase> {};

TEST_P(ServiceEnables, ACircleIsAFinding) {
    std::string devices;
    for (std::size_t i = 0; i < 4; ++i) {
        const char by = GetParam().enables[i];
        devices += (i > 0 ? ", {name: " : "{name: ") + std::string(1, static_cast<char>('A' + i)) +
                   ", address: " + std::to_string(i + 1) +
                   (by == '-' ? "" : ", poll_enable: system.device." + std::string(1, by) + ".answering") +
                   ", variables: []}";
    }
    const std::string line = "{devices: [" + devices + "]}";
    std::string found;
    for (const auto& finding : interpret(document({.line = line})).findings)
        if (finding.code == "service.circular") found += finding.arguments.at(0).second;
    EXPECT_EQ(found, GetParam().findings);
}

INSTANTIATE_TEST_SUITE_P(All, ServiceEnables,
                         ::testing::Values(EnableCase{"----", ""}, EnableCase{"A---", "A"},
                                           EnableCase{"-AB-", ""}, EnableCase{"BA--", "AB"},
                                           EnableCase{"BCA-", "ABC"}, EnableCase{"BCDB", "BCD"},
                                           EnableCase{"AABB", "A"}, EnableCase{"BADC", "ABCD"}));

struct WidthCase {
    const char* name;
    const char* keys;
    bool warned;
};

class ServiceWidths : public ::testing::TestWithParam<WidthCase> {};

TEST_P(ServiceWidths, ACounterThatOutgrowsItsRegisterIsAWarning) {
    const auto& [name, type, warned] = GetParam();
    const auto checked = served("source: {variable: " + std::string(name) + "}", type);
    const auto count = std::ranges::count(checked.findings, "service.outgrows", &Finding::code);
    EXPECT_EQ(count == 1, warned);
    EXPECT_EQ(findings_text(checked), "");
}

INSTANTIATE_TEST_SUITE_P(All, ServiceWidths,
                         ::testing::Values(WidthCase{"system.uptime", "uint16", true},
                                           WidthCase{"system.uptime", "int16", true},
                                           WidthCase{"system.uptime", "uint32", false},
                                           WidthCase{"system.uptime", "int32", false},
                                           WidthCase{"system.uptime", "double", false},
                                           WidthCase{"system.uptime", "uint16, scale: 60", false},
                                           WidthCase{"system.pulse_1s", "uint16", false},
                                           WidthCase{"system.first_cycle", "bool, bit: 0", false}));

TEST(ServiceTable, EachTriggerHasARateLimit) {
    for (const auto& field : service_fields()) {
        EXPECT_EQ(field.type == DataType::boolean, field.min_interval > Duration::zero()) << field.word;
        const bool is_pulse = field.period > Duration::zero();
        EXPECT_TRUE(!is_pulse || field.min_interval < field.period) << field.word;
    }
}

}  // namespace service_test
}  // namespace takt::model::test
