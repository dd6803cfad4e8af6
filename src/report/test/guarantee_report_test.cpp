// Bounds are rounded up, never down: a report must not promise more than the proof.
#include "takt/report/plans/guarantee_report.hpp"

#include <gtest/gtest.h>

#include "sample.hpp"

namespace takt::report {
namespace guarantee_report_test {

using namespace test;
using namespace std::chrono_literals;

plan::Bound bound() {
    return {.transaction = 12345678ns, .failure = 50ms, .response = 100ms, .deadline = 500ms, .age = 1500ms};
}

TEST(GuaranteeReport, BoundsAsJsonAreRoundedUpAndNullWithoutABound) {
    auto object = file::Json::object();
    set_bound(object, bound());
    EXPECT_EQ(object.dump(), R"({"c_us":12346,"f_us":50000,"response_us":100000,"response_fault_us":null,)"
                             R"("response_dead_us":null,"deadline_us":500000,"age_us":1500000})");
    auto empty = file::Json::object();
    set_bound(empty, {});
    EXPECT_JSON(at(empty, "response_us"), file::Json());
}

TEST(GuaranteeReport, AgesOfTheVariablesOfARequest) {
    plan::LineGuarantee guarantee;
    guarantee.ages = {{}, {100ms, std::nullopt, 1us}};
    plan::Request request;
    request.device = 1;
    EXPECT_EQ(ages_json(guarantee, request).dump(), "[]");
    request.variables = {2, 1, 0};
    EXPECT_EQ(ages_json(guarantee, request).dump(), "[1,null,100000]");
}

TEST(GuaranteeReport, LoadAndVerdictOfALine) {
    plan::LineGuarantee line;
    line.utilization = 0.4567;
    for (const auto language : kLanguages) {
        const Texts texts(language);
        for (const auto verdict : {plan::Verdict::holds, plan::Verdict::response_unknown,
                                   plan::Verdict::not_proved, plan::Verdict::cannot_hold}) {
            const auto text = guarantee_text(texts, line, verdict, "");
            expect_contains(text, "45.7 %");
            expect_contains(text, texts("app.verdict." + std::string(plan::name(verdict))));
            expect_complete(text);
            const auto unknown = guarantee_text(texts, line, verdict, "Котёл");
            EXPECT_EQ(unknown.contains("45.7 %"), verdict == plan::Verdict::holds) << "time-outs are no load";
            EXPECT_EQ(unknown.contains("Котёл"), verdict != plan::Verdict::holds);
            expect_complete(unknown);
        }
    }
}

plan::Measure measure(std::size_t line, plan::Goal goal) {
    plan::Measure made;
    made.kinds = {plan::MeasureKind::time_outs, plan::MeasureKind::periods};
    made.line = line;
    made.goal = goal;
    made.changes = {{"lines[0]", "Линия", "response_timeout", "", "20ms"}};
    made.variable = "Давление";
    made.after = 10ms;
    made.deadline = 20ms;
    made.utilization_before = 1.5;
    made.utilization_after = 0.5;
    return made;
}

TEST(GuaranteeReport, MeasuresOfEachLineThatMissesSomething) {
    model::Project project;
    project.lines.resize(3);
    for (std::size_t i = 0; i < 3; ++i) project.lines[i].name = "line" + std::to_string(i);
    plan::Proof proof;
    proof.lines.resize(3);
    for (std::size_t i = 0; i < 3; ++i) proof.lines[i].line = i;
    proof.lines[1].feasible = proof.lines[2].feasible = false;
    proof.measures.unfinished = {2};
    proof.measures.found = {measure(1, plan::Goal::sound), measure(1, plan::Goal::with_dead_device)};
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = measures_text(texts, project, proof);
        expect_complete(text);
        EXPECT_EQ(text.find("line0"), std::string::npos) << "nothing to do";
        expect_contains(text, texts("app.plan.measures", {{"line", "line1"}}));
        expect_contains(text, texts("app.plan.no_measure", {{"line", "line2"}}));
        expect_contains(text, texts("app.plan.search_limit", {{"line", "line2"}}));
        EXPECT_EQ(text.find(texts("app.plan.search_limit", {{"line", "line1"}})), std::string::npos);
        EXPECT_EQ(count_of(text, texts("app.measure.time_outs") + " + " + texts("app.measure.periods")), 2U);
        expect_contains(text, texts("app.goal.with_dead_device"));
        expect_contains(text, "Давление");
        expect_contains(text, texts("app.unbounded"));
    }
    expect_contains(measures_text(english(), project, proof), "150.0 % → 50.0 %");
    project.lines[1].devices.resize(1);
    project.lines[1].devices[0].name = "D";  // its turnaround is not known: time-outs are no load
    EXPECT_FALSE(measures_text(english(), project, proof).contains("150.0 %"));
    expect_contains(measures_text(english(), project, proof), "50.0 %");
    EXPECT_EQ(measures_text(english(), {}, {}), "");
}

TEST(GuaranteeReport, MeasuresAsJson) {
    const std::vector all{measure(0, plan::Goal::sound), measure(1, plan::Goal::with_faults)};
    const auto list = measures_json(english(), all, 1);
    ASSERT_EQ(size_of(list), 1U);
    EXPECT_EQ(at(list, 0, "kinds").dump(), R"(["time_outs","periods"])");
    EXPECT_JSON(at(list, 0, "goal"), "with_faults");
    EXPECT_JSON(at(list, 0, "response_before_us"), file::Json());
    EXPECT_JSON(at(list, 0, "response_after_us"), 10000);
    EXPECT_EQ(at(list, 0, "changes", 0).dump(),
              R"({"path":"lines[0]","name":"Линия","key":"response_timeout","from":"","to":"20ms"})");
    EXPECT_EQ(measures_json(english(), all, 7).dump(), "[]");
}

TEST(GuaranteeReport, ManyChangesAreCutOff) {
    std::vector<plan::Change> changes(1000, {"lines[0].devices[0]", "D", "attempts", "3", "1"});
    const auto text = changes_text(english(), changes);
    EXPECT_EQ(count_of(text, "\n"), 12U);
    expect_contains(text, english()("app.change.more", {{"count", "989"}}));
    changes.resize(12);
    EXPECT_EQ(count_of(changes_text(english(), changes), "attempts"), 12U) << "twelve fit";
    EXPECT_EQ(changes_text(english(), {}), "");
    EXPECT_EQ(size_of(changes_json(changes)), 12U);
}

TEST(GuaranteeReport, AChangeOfTheProjectHasNoPath) {
    const std::vector<plan::Change> change{{"", "", "derive_timeouts", "false", "true"}};
    EXPECT_EQ(
        changes_text(english(), change),
        "      " +
            english()("app.change.project", {{"key", "derive_timeouts"}, {"to", "true"}, {"from", "false"}}) +
            '\n');
}

}  // namespace guarantee_report_test
}  // namespace takt::report
