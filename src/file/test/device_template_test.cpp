#include <gtest/gtest.h>

#include <map>
#include <string>

#include "outline.hpp"
#include "takt/file/load.hpp"
#include "takt/model/findings.hpp"

namespace takt::file {
namespace device_template_test {

using Findings = std::vector<std::string>;
using Files = std::map<std::string, std::string>;

constexpr std::string_view kMeter =
    "takt: 1\n"
    "parameters: {base: 10, phases}\n"
    "poll_period: 2s\n"
    "variables:\n"
    "  - {name: Power, type: int, register: $(base), read: 3}\n"
    "  - {name: Energy, type: int, register: $(base + 7), read: 3, comment: $(phases) of "
    "$(device)/$(address)}\n";

Loaded load_with(const std::string& devices, const Files& files) {
    return load_text("x/p.yaml", "takt: 1\nlines:\n- name: L\n  port: p\n  devices:\n" + devices,
                     [&](const std::string& name) -> Result<std::string> {
                         const auto found = files.find(name);
                         if (found == files.end()) return fail(Code::cannot_open, name, 2);
                         return found->second;
                     });
}

Findings findings_with(const std::string& device, std::string_view meter) {
    return locations_and_codes(load_with("  - {name: A, address: 1, device_template: t.yaml" + device + "}\n",
                                         {{"x/t.yaml", std::string(meter)}}));
}

TEST(DeviceTemplates, CompleteADevice) {
    const auto loaded = load_with(
        "  - {name: A, address: 1, device_template: sub/../t.yaml, parameters: {phases: 3}}\n"
        "  - {name: B, address: 2, device_template: t.yaml, parameters: {phases: 1, base: 100}, poll_period: "
        "5s,\n     variables: [{name: Own, type: int, register: 0, read: 3}]}\n",
        {{"x/t.yaml", std::string(kMeter)}});
    ASSERT_EQ(locations_and_codes(loaded), Findings{});
    EXPECT_EQ(loaded.document.files, (std::vector<std::string>{"x/p.yaml", "x/t.yaml"}));
    const auto checked = model::interpret(loaded.document);
    EXPECT_TRUE(checked.findings.empty()) << checked.findings[0].code << checked.findings[0].path;
    const auto& devices = checked.project.lines.at(0).devices;
    ASSERT_EQ(devices.at(0).variables.size(), 2U);
    EXPECT_EQ(devices[0].variables[1].name, "A.Energy");
    EXPECT_EQ(devices[0].variables[1].register_number, 17);
    EXPECT_EQ(devices[0].variables[1].comment, "3 of A/1");
    EXPECT_EQ(devices[0].variables[1].location, (model::SourceLocation{1, 6, 5}));
    EXPECT_EQ(devices[0].poll_period, std::chrono::seconds(2));
    ASSERT_EQ(devices.at(1).variables.size(), 3U);
    EXPECT_EQ(devices[1].variables[0].name, "B.Power");
    EXPECT_EQ(devices[1].variables[0].register_number, 100);
    EXPECT_EQ(devices[1].variables[2].name, "Own");
    EXPECT_EQ(devices[1].poll_period, std::chrono::seconds(5));
}

TEST(DeviceTemplates, MistakesHaveTheirPlace) {
    const struct {
        std::string device;
        std::string_view meter;
        Findings findings;
    } cases[] = {
        {"", kMeter, {"6:44 template.parameter_missing"}},
        {", parameters: {phases: 3, bass: 1}", kMeter, {"6:76 template.parameter_unknown"}},
        {", parameters: {phases: 3, base: x}", kMeter, {"6:82 template.not_an_integer"}},
        {", parameters: {phases: [3]}", kMeter, {"6:73 template.parameter_value"}},
        {", parameters: 5", kMeter, {"6:64 template.parameters"}},
        {"", "takt: 1\nlines: []\n", {"1/1:1 template.none"}},
        {"", "- 1\n", {"1/1:1 template.none"}},
        {"", "takt: 1\ndevice_template: t.yaml\n", {"1/2:18 template.nested"}},
        {"", "takt: 1\nvariables: {a: 1}\n", {"1/2:12 template.variables"}},
        {"", "takt: 1\nvariables: [{name: $(x)}]\n", {"1/2:20 template.unknown"}},
        {"",
         "takt: 1\nparameters: {a: 1}\nvariables: [{name: $(a * 2)}, {name: $(a}]\n",
         {"1/3:20 template.expression", "1/3:38 template.expression"}},
        {"",
         "takt: 1\nparameters: {a-b: 1, device: 2}\n",
         {"1/2:14 template.parameter_name", "1/2:22 template.parameter_name"}},
        {"", "takt: [\n", {"1/1:8 unclosed_bracket"}},
        {"", "takt: 1\nvariables: none.csv\n", {"1/2:12 not_found"}},
    };
    for (const auto& [device, meter, findings] : cases)
        EXPECT_EQ(findings_with(device, meter), findings) << device << meter;
    EXPECT_EQ(locations_and_codes(load_with("  - {name: A, device_template: none.yaml}\n", {})),
              Findings{"6:32 not_found"});
}

TEST(DeviceTemplates, AMistakeInATemplateIsReportedOnce) {
    std::string devices;
    for (int i = 1; i <= 30; ++i)
        devices += "  - {name: D" + std::to_string(i) + ", address: " + std::to_string(i) +
                   ", device_template: t.yaml}\n";
    const auto loaded =
        load_with(devices, {{"x/t.yaml",
                             "takt: 1\nvariables:\n- {name: V, type: intt, register: 1, read: 3, sccale: 1}\n"
                             "- {name:W, type: int, register: \"2\", read: 3, scale: 0,1}\n"}});
    const auto checked = model::interpret(loaded.document);
    std::vector<std::string> codes;
    for (const auto& finding : checked.findings)
        codes.push_back(finding.code + ' ' + std::to_string(finding.location.line));
    EXPECT_EQ(codes, (std::vector<std::string>{"field.unknown_word 3", "key.unknown 3", "key.no_space 4",
                                               "field.quoted_number 4", "number.comma 4"}));
}

TEST(DeviceTemplates, ATableMayHaveExpressions) {
    const auto loaded =
        load_with("  - {name: A, address: 1, device_template: sub/t.yaml, parameters: {base: 20}}\n",
                  {{"x/sub/t.yaml", "takt: 1\nparameters: {base: 0}\nvariables: t.csv\n"},
                   {"x/sub/t.csv", "name,type,read,register\nV,int,3,$(base + 5)\n"}});
    ASSERT_EQ(locations_and_codes(loaded), Findings{});
    const auto checked = model::interpret(loaded.document);
    ASSERT_TRUE(checked.findings.empty()) << checked.findings[0].code;
    EXPECT_EQ(checked.project.lines[0].devices[0].variables.at(0).register_number, 25);
}

TEST(DeviceTemplates, ASmallProjectCannotBecomeALargeOne) {
    std::string variables = "takt: 1\nvariables:\n";
    for (int i = 0; i < 3000; ++i) variables += "- {name: V, type: int, register: 1, read: 3}\n";
    std::string devices;
    for (int i = 0; i < 60; ++i) devices += "  - {name: D, address: 1, device_template: t.yaml}\n";
    const auto loaded = load_with(devices, {{"x/t.yaml", variables}});
    const auto findings = locations_and_codes(loaded);
    ASSERT_FALSE(findings.empty());
    EXPECT_TRUE(findings.back().ends_with("template.too_large")) << findings.back();
}

}  // namespace device_template_test
}  // namespace takt::file
