#include "takt/report/plans/plan_report.hpp"

#include <gtest/gtest.h>

#include "sample.hpp"
#include "takt/base/utf8.hpp"
#include "takt/plan/proof.hpp"
#include "takt/report/plans/findings_report.hpp"

namespace takt::report {
namespace plan_report_test {

using namespace test;
using namespace std::chrono_literals;

TEST(PlanReport, ARowForEachRequestWithItsReason) {
    const auto project = project_of(kBoiler);
    const auto plan = plan::make_plan(project);
    const auto text = plan_text(english(), project, plan);
    expect_contains(text, "rs485-1 (rtu, 19200 bit/s): ");
    expect_contains(text, "Supply, Return, Setpoint");
    expect_contains(text, "0x01+0x05 3");
    expect_contains(text, "0x03 0..5 ");
    EXPECT_EQ(count_of(text, "└ "), plan.lines[0].requests.size()) << "each has its reason";
    expect_complete(text);
}

TEST(PlanReport, ColumnsAreAlignedWithCyrillicNames) {
    const auto project = project_of(kBoiler);
    const auto text = plan_text(english(), project, plan::make_plan(project));
    std::size_t column = std::string::npos;
    for (std::size_t begin = 0, end = 0; (end = text.find('\n', begin)) != std::string::npos;
         begin = end + 1) {
        const auto line = text.substr(begin, end - begin);
        const auto unit = line.find(" 16  0x");
        if (unit == std::string::npos) continue;
        const auto width = count_characters(line.substr(0, unit));
        if (column == std::string::npos) column = width;
        EXPECT_EQ(width, column) << line;
    }
    EXPECT_NE(column, std::string::npos);
}

TEST(PlanReport, IsCompleteInEveryLanguage) {
    for (const auto& yaml : {kBoiler, kEmptyLine, overloaded()}) {
        const auto project = project_of(yaml);
        const auto proof = plan::prove(project, false, true);
        for (const auto language : kLanguages) {
            const Texts texts(language);
            const auto text = plan_text(texts, project, proof.plan, proof.lines);
            expect_complete(text);
            expect_contains(text, project.lines[0].name);
            expect_contains(text, texts("app.oldest"));
            expect_contains(text, texts("app.plan.legend"));
            const auto all = plan_text(texts, project, proof.plan, proof.lines, {.figures = Figures::proof});
            expect_complete(all);
            expect_contains(all, texts("app.deadline"));
            expect_contains(all, texts("app.plan.legend.proof"));
        }
    }
}

TEST(PlanReport, AnOverloadedLineIsReported) {
    const auto project = project_of(overloaded());
    const auto plan = plan::make_plan(project);
    expect_contains(plan_text(english(), project, plan), english()("app.plan.overloaded"));
}

TEST(PlanReport, TheTableOfAUsualProjectFitsATerminal) {
    const auto project = project_of(R"(takt: 1
lines:
  - name: rs485-1
    port: /dev/ttyUSB0
    baud: 19200
    devices:
      - name: Boiler
        address: 16
        variables:
          - {name: Temperature, type: float, register: 0, read: 0x03}
)");
    const auto proof = plan::prove(project, false, false);
    for (const auto figures : {Figures::usual, Figures::proof}) {
        const auto text = plan_text(english(), project, proof.plan, proof.lines, {.figures = figures});
        std::size_t begin = text.find('\n') + 1;  // after the heading
        for (std::size_t end = 0; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1)
            EXPECT_LE(count_characters(text.substr(begin, end - begin)),
                      figures == Figures::usual ? 80U : 84U)
                << text;
    }
}

TEST(PlanReport, NamesAreCutToTheWidthOfATerminal) {
    const auto project = project_of(kBoiler);
    const auto proof = plan::prove(project, false, false);
    const auto text = plan_text(english(), project, proof.plan, proof.lines, {.columns = 78});
    EXPECT_GT(count_of(text, "…\n"), 0U);
    for (std::size_t row = text.find("\n  Ко"); row != std::string::npos; row = text.find("\n  Ко", row + 1))
        EXPECT_LE(count_characters(text.substr(row + 1, text.find('\n', row + 1) - row - 1)), 78U) << text;
}

TEST(PlanReport, ALineThatIsNeverIdleIsBusy) {
    const auto project = project_of(R"(takt: 1
lines:
  - name: rs485-1
    port: /dev/ttyUSB0
    devices:
      - {name: Fast, address: 1, turnaround: 5ms, poll_period: 0,
         variables: [{name: a, type: int16, register: 0, read: 0x03}]}
      - {name: Slow, address: 2, turnaround: 5ms,
         variables: [{name: b, type: int16, register: 0, read: 0x03}]}
)");
    const auto proof = plan::prove(project, false, false);
    const auto text = plan_text(english(), project, proof.plan, proof.lines);
    EXPECT_EQ(count_of(text, "line busy 100.0 %"), 2U) << text;
    expect_contains(text, "share of the line: Fast 9");
    const auto lines = plan_json(english(), project, proof.plan, proof, false);
    EXPECT_JSON(at(lines, 0, "utilization"), 1.0);
    EXPECT_EQ(size_of(at(lines, 0, "devices")), 2U);
    EXPECT_JSON(at(lines, 0, "devices", 0, "name"), "Fast");
}

TEST(PlanReport, AProjectWithoutLinesIsEmpty) {
    EXPECT_EQ(plan_text(english(), {}, {}), "");
    EXPECT_EQ(plan_json(english(), {}, {}, {}, false).dump(), "[]");
}

TEST(PlanReport, NamesOfManyVariables) {
    model::Device device;
    plan::Request request;
    const auto add = [&](std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            request.variables.push_back(device.variables.size());
            device.variables.push_back({.name = "v" + std::to_string(device.variables.size())});
        }
        return variables_text(device, request);
    };
    EXPECT_EQ(variables_text(device, request), "");
    EXPECT_EQ(add(1), "v0");
    EXPECT_EQ(add(3), "v0, v1, v2, v3");
    EXPECT_EQ(add(1), "v0, v1, v2, … v4 (5)");
    EXPECT_EQ(add(60000), "v0, v1, v2, … v60004 (60005)");
}

TEST(PlanReport, TheCausesOfARequest) {
    model::Project project;
    project.locals.push_back({.name = "go"});
    project.locals.push_back({.name = "save"});
    plan::Request request;
    const auto text = [&] { return when_text(english(), project, request); };
    EXPECT_EQ(text(), "");
    request.write = wire::Function::write_multiple_registers;
    EXPECT_EQ(text(), english()("app.when.command"));
    request.period = 0ms;
    EXPECT_EQ(text(), english()("app.when.always"));
    request.period = 1s;
    EXPECT_EQ(text(), "1 s");
    request.phase = 300ms;
    EXPECT_EQ(text(), "1 s +300 ms");
    request.read_trigger = 0;
    request.write_on_change = true;
    request.write_trigger = 1;
    EXPECT_EQ(text(), "1 s +300 ms, " + english()("app.when.read_trigger", {{"local", "go"}}) + ", " +
                          english()("app.when.change") + ", " +
                          english()("app.when.write_trigger", {{"local", "save"}}));
}

TEST(PlanReport, RequestsThatTakeTurnsShareARow) {
    const auto project = project_of(kBoiler);
    auto plan = plan::make_plan(project);
    auto& requests = plan.lines[0].requests;
    auto turn = requests[1];
    ASSERT_TRUE(turn.period && !turn.write);
    for (int i = 1; i < 9; ++i) {
        turn.phase = i * 50ms;
        requests.insert(requests.begin() + 1 + i, turn);
    }
    const auto text = plan_text(english(), project, plan);
    expect_contains(text, "500 ms +0, 50, 100, 150, 200, 250 ms … (9)");
    EXPECT_EQ(count_of(text, "└ "), requests.size() - 8);
}

TEST(PlanReport, JsonHasTheKeysOfTheDocumentation) {
    const auto project = project_of(kBoiler);
    const auto proof = plan::prove(project, false, true);
    const auto lines = plan_json(english(), project, proof.plan, proof, true);
    ASSERT_EQ(size_of(lines), 1U);
    EXPECT_JSON(at(lines, 0, "name"), "rs485-1");
    EXPECT_JSON(at(lines, 0, "framing"), "rtu");
    EXPECT_JSON(at(lines, 0, "baud"), 19200);
    EXPECT_JSON(at(lines, 0, "feasible"), true);
    EXPECT_EQ(size_of(at(lines, 0, "requests")), proof.plan.lines[0].requests.size());
    for (const char* key : {"utilization", "cycle_us", "ungrouped_requests", "request_count", "feasible_edf",
                            "worst_utilization", "measures", "compare"})
        EXPECT_NE(lines.dump().find('"' + std::string(key) + "\":"), std::string::npos) << key;
    const auto& first = at(lines, 0, "requests", 1);
    EXPECT_JSON(at(first, "device"), "Котёл");
    EXPECT_JSON(at(first, "unit"), 16U);
    EXPECT_JSON(at(first, "function"), 3);
    EXPECT_JSON(at(first, "start"), 0U);
    EXPECT_JSON(at(first, "quantity"), 6U);
    EXPECT_EQ(at(first, "variables").dump(), R"(["Supply","Return","Setpoint"])");
    EXPECT_JSON(at(first, "period_ms"), 500.0);
    EXPECT_EQ(size_of(at(first, "ages_us")), 3U);
}

TEST(PlanReport, ALineThatIsNoSerialLineHasNoBaud) {
    const auto project = project_of(kEmptyLine);
    const auto proof = plan::prove(project, false, false);
    const auto lines = plan_json(english(), project, proof.plan, proof, false);
    EXPECT_JSON(at(lines, 0, "baud"), file::Json());
    EXPECT_EQ(lines.dump().find("\"compare\""), std::string::npos);
    EXPECT_EQ(size_of(at(lines, 0, "requests")), 0U);
}

TEST(PlanReport, AppliedMeasures) {
    const auto sound = project_of(kBoiler);
    const auto proof = plan::prove(sound, false, true);
    const auto none = plan::apply_measures(sound, proof, false);
    EXPECT_EQ(applied_text(english(), sound, proof, none), english()("app.fix.nothing") + '\n');

    const auto project = project_of(overloaded());
    const auto late = plan::prove(project, false, true);
    const auto helpless = plan::apply_measures(project, late, false);
    ASSERT_EQ(helpless.not_helped.size(), 1U) << "no change of the plan alone halves the load";
    expect_contains(applied_text(english(), project, late, helpless),
                    english()("app.fix.none", {{"line", "slow"}}));

    auto applied = helpless;
    applied.changes.push_back({"lines[0].devices[1]", "D2", "poll_period", "20ms", "100ms"});
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = applied_text(texts, project, late, applied);
        expect_complete(text);
        expect_contains(text, "poll_period: 100ms");
        EXPECT_LT(text.find(texts("app.fix.before")), text.find(texts("app.fix.after")));
    }
    const auto json = applied_json(english(), applied);
    EXPECT_JSON(at(json, "changes", 0, "to"), "100ms");
    EXPECT_EQ(size_of(at(json, "lines")), 1U);
}

TEST(PlanReport, TheObjectOfAPlanHasItsFindingsLast) {
    host::LoadedProject loaded;
    loaded.project = project_of(overloaded());
    loaded.files = {"slow.yaml"};
    loaded.findings.resize(1);
    loaded.findings[0].code = "guarantee.late";
    const auto proof = plan::prove(loaded.project, false, true);
    const auto lines = plan_json(english(), loaded.project, proof.plan, proof, false).dump();
    const auto findings = findings_json(english(), loaded).dump();
    EXPECT_EQ(project_plan_json(english(), loaded, proof, nullptr, false).dump(),
              R"({"lines":)" + lines + R"(,"findings":)" + findings + '}');
    const auto applied = plan::apply_measures(loaded.project, proof, false);
    EXPECT_EQ(project_plan_json(english(), loaded, proof, &applied, false).dump(),
              R"({"lines":)" + lines + R"(,"fixed":)" + applied_json(english(), applied).dump() +
                  R"(,"findings":)" + findings + '}');
    EXPECT_EQ(no_plan_json(english(), loaded).dump(), R"({"lines":[],"findings":)" + findings + '}');
}

}  // namespace plan_report_test
}  // namespace takt::report
