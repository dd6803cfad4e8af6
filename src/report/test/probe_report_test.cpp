#include "takt/report/states/probe_report.hpp"

#include <gtest/gtest.h>

#include "sample.hpp"

namespace takt::report {
namespace probe_report_test {

using namespace test;
using namespace std::chrono_literals;
using bus::AreaProbe;
using bus::ProbeEnd;
using bus::ProbeFindings;
using wire::Area;

const ProbeRun kRun{"rtu:///dev/ttyS1", 16, 321, 1234ms, false};

AreaProbe area_probe(Area area, std::vector<model::ItemRange> readable, ProbeEnd end = ProbeEnd::complete) {
    AreaProbe made;
    made.area = area;
    made.result.readable = std::move(readable);
    made.result.end = end;
    made.result.requests = 100;
    made.result.longest = 16;
    return made;
}

ProbeFindings sample() {
    ProbeFindings findings;
    findings.areas = {area_probe(Area::holding_register, {{0, 99}, {200, 200}}),
                      area_probe(Area::input_register, {}, ProbeEnd::no_function),
                      area_probe(Area::coil, {{0, 7}})};
    findings.exceptions = {{1, 24}, {2, 60}};
    return findings;
}

TEST(ProbeReport, ALineForEachRange) {
    EXPECT_EQ(probe_text(sample()), "holding_register 0..99\nholding_register 200\ncoil 0..7\n");
    EXPECT_EQ(probe_text({}), "");
    ProbeFindings findings;
    findings.areas = {area_probe(Area::coil, {{0, 7}})};
    findings.areas[0].result.refused = {{{9, 10}, bus::ProbeReply::failure}};
    EXPECT_EQ(probe_text(findings), "coil 0..7\ncoil 9..10 exception 4\n");
}

TEST(ProbeReport, TheRequestThatIsNext) {
    for (const auto area : {Area::coil, Area::discrete_input, Area::input_register, Area::holding_register})
        EXPECT_EQ(probe_progress({.area = area, .start = 512}), std::string(wire::name(area)) + " 512");
}

TEST(ProbeReport, KeysOfAProjectFile) {
    auto findings = sample();
    EXPECT_EQ(probe_yaml(findings),
              "offers:\n  coil: [0..7]\n  holding_register: [0..99, 200]\n"
              "readable:\n  coil: [0..7]\n  holding_register: [0..99, 200]\n");
    findings.areas[0].result.limited = true;
    EXPECT_TRUE(probe_yaml(findings).ends_with("registers_per_request: 16\n"));
    findings.areas[1] = area_probe(Area::input_register, {{1, 2}});
    findings.areas[1].result.limited = true;
    findings.areas[1].result.longest = 8;
    EXPECT_TRUE(probe_yaml(findings).ends_with("registers_per_request: 8\n")) << "what both accept";
    EXPECT_EQ(probe_yaml({}), "");
}

TEST(ProbeReport, ALimitOfBitsOrOfOneRegisterIsNoLimitOfRegisters) {
    ProbeFindings findings;
    findings.areas = {area_probe(Area::coil, {{0, 7}}), area_probe(Area::holding_register, {{0, 1}})};
    findings.areas[0].result.limited = findings.areas[1].result.limited = true;
    findings.areas[1].result.longest = 1;
    EXPECT_EQ(probe_yaml(findings).find("registers_per_request"), std::string::npos);
}

TEST(ProbeReport, TheKeysAreReadWithoutFindings) {
    std::string keys = probe_yaml(sample());
    for (std::size_t line = 0; (line = keys.find('\n', line)) + 1 < keys.size(); line += 9)
        keys.insert(line + 1, "        ");
    const auto project = project_of(
        "takt: 1\nlines:\n  - name: l\n    transport: serial\n    port: /dev/ttyS1\n    devices:\n"
        "      - name: d\n        address: 1\n        strategy: optimal\n        variables: []\n        " +
        keys);
    const auto& readable = project.lines[0].devices[0].readable;
    EXPECT_EQ(readable[static_cast<std::size_t>(Area::holding_register)],
              (std::vector<model::ItemRange>{{0, 99}, {200, 200}}));
}

TEST(ProbeReport, JsonOfAreas) {
    auto findings = sample();
    findings.areas[1].result.next = 4000;
    findings.areas[0].result.refused = {{{300, 301}, bus::ProbeReply::bad_value},
                                        {{302, 302}, bus::ProbeReply::failure}};
    findings.areas[0].result.tested = {{0, 999}, {1500, 1501}};
    const auto json = probe_json(findings, kRun);
    EXPECT_EQ(at(json, "areas", 0).dump(),
              R"({"area":"holding_register","function":3,"end":"complete","ranges":[[0,99],[200,200]],)"
              R"("items":101,"refused":[{"first":300,"last":301,"exception":3},{"first":302,"last":302,)"
              R"("exception":4}],"longest_read":16,"limited":false,"step":1,"requests":100,"next":null,)"
              R"("addresses":65536,"tested":1002,"tested_ranges":[[0,999],[1500,1501]],"longest_gap":[1502,)"
              R"(65535]})");
    EXPECT_JSON(at(json, "areas", 1, "end"), "no_function");
    EXPECT_JSON(at(json, "areas", 1, "next"), 4000U);
    EXPECT_EQ(at(json, "readable").dump(), R"({"holding_register":"0..99, 200","coil":"0..7"})");
    EXPECT_EQ(at(json, "exceptions").dump(), R"({"1":24,"2":60})");
}

TEST(ProbeReport, JsonOfTheRun) {
    auto findings = sample();
    const auto json = probe_json(findings, kRun);
    EXPECT_JSON(at(json, "target"), "rtu:///dev/ttyS1");
    EXPECT_JSON(at(json, "unit"), 16U);
    EXPECT_JSON(at(json, "requests"), 300U);
    EXPECT_JSON(at(json, "transmissions"), 321U);
    EXPECT_JSON(at(json, "duration_ms"), 1234);
    EXPECT_JSON(at(json, "complete"), true);
    findings.stopped = true;
    EXPECT_JSON(at(probe_json(findings, kRun), "complete"), false);
}

TEST(ProbeReport, RemarksByTheEndOfEachArea) {
    const struct {
        ProbeEnd end;
        const char* code;
    } cases[] = {{ProbeEnd::out_of_requests, "app.probe.out_of_requests"},
                 {ProbeEnd::no_function, "app.probe.no_function"},
                 {ProbeEnd::no_answer, "app.probe.no_answer"},
                 {ProbeEnd::fell_silent, "app.probe.fell_silent"},
                 {ProbeEnd::stopped, "app.probe.stopped"}};
    for (const auto language : kLanguages) {
        const Texts texts(language);
        for (const auto& [end, code] : cases) {
            ProbeFindings findings;
            findings.areas = {area_probe(Area::coil, {}, end)};
            findings.areas[0].result.next = 512;
            findings.areas[0].result.tested = {{0, 511}};
            const auto text = probe_summary(texts, findings, kRun);
            expect_complete(text);
            expect_contains(text, texts(code, {{"area", "coil"},
                                               {"next", "512"},
                                               {"requests", "100"},
                                               {"tested", "512"},
                                               {"addresses", "65536"},
                                               {"range", "0..65535"},
                                               {"gap", "512..65535"}}));
        }
    }
}

TEST(ProbeReport, RemarksOnLimitsAndSteps) {
    ProbeFindings findings;
    findings.areas = {area_probe(Area::coil, {{0, 7}})};
    auto& area = findings.areas[0];
    area.searched = {0, 2000};
    area.result.tested = {{0, 2000}};
    auto text = probe_summary(english(), findings, kRun);
    expect_contains(text, english()("app.probe.all_tested",
                                    {{"area", "coil"}, {"addresses", "2001"}, {"range", "0..2000"}}));
    EXPECT_EQ(count_of(text, "\n"), 2U);
    area.result.limited = true;
    area.step = 8;
    area.result.tested = {{0, 255}, {264, 264}};
    text = probe_summary(english(), findings, kRun);
    expect_contains(text, english()("app.probe.limited", {{"area", "coil"}, {"longest", "16"}}));
    expect_contains(text, english()("app.probe.step", {{"area", "coil"},
                                                       {"step", "8"},
                                                       {"tested", "257"},
                                                       {"addresses", "2001"},
                                                       {"range", "0..2000"},
                                                       {"whole", "0..255"},
                                                       {"gap", "265..2000"}}));
    area.result.end = ProbeEnd::stopped;
    EXPECT_EQ(probe_summary(english(), findings, kRun).find("--step 1"), std::string::npos);
}

TEST(ProbeReport, RemarksOnRefusalsAndAreasNotBegun) {
    for (const auto language : kLanguages) {
        const Texts texts(language);
        ProbeFindings findings;
        findings.areas = {area_probe(Area::coil, {{0, 7}})};
        findings.areas[0].result.refused = {{{9, 10}, bus::ProbeReply::bad_value}};
        findings.not_begun = {Area::input_register, Area::discrete_input};
        auto text = probe_summary(texts, findings, kRun);
        expect_complete(text);
        expect_contains(
            text, texts("app.probe.refused", {{"area", "coil"}, {"range", "9..10"}, {"exception", "3"}}));
        expect_contains(text, texts("app.probe.not_begun", {{"areas", "input_register, discrete_input"}}));
        findings.areas[0].result.refused.clear();
        findings.areas[0].result.one_refusal = true;
        text = probe_summary(texts, findings, kRun);
        expect_contains(text, texts("app.probe.one_refusal", {{"area", "coil"}}));
    }
}

TEST(ProbeReport, HugeFindings) {
    ProbeFindings findings;
    std::vector<model::ItemRange> ranges;
    for (int i = 0; i < 65536; i += 2)
        ranges.push_back({static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(i)});
    findings.areas = {area_probe(Area::holding_register, ranges)};
    EXPECT_EQ(count_of(probe_text(findings), "\n"), 32768U);
    EXPECT_JSON(at(probe_json(findings, kRun), "areas", 0, "items"), 32768U);
}

}  // namespace probe_report_test
}  // namespace takt::report
