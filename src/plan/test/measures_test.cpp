// Projects that are infeasible in one known way: their findings, and the measures that help.
#include "takt/plan/measures.hpp"

#include <gtest/gtest.h>

#include "golden_project.hpp"
#include "takt/plan/guarantee_findings.hpp"
#include "takt/text/catalogue.hpp"

namespace takt::plan {
namespace measures_test {

using namespace test;
using model::Severity;

std::vector<LineGuarantee> proved(const model::Project& project) {
    return guarantee(project, make_plan(project));
}

std::vector<Measure> measures_of(const model::Project& project, bool dead_device = false) {
    const Plan plan = make_plan(project);
    return measures(project, plan, guarantee(project, plan), dead_device).found;
}

std::vector<model::Finding> verdict_of(const model::Project& project, bool prove = false) {
    const Plan plan = make_plan(project);
    return guarantee_findings(project, plan, guarantee(project, plan), prove);
}

std::vector<std::string_view> kinds_of(const std::vector<Measure>& measures) {
    std::vector<std::string_view> names;
    for (const auto& measure : measures)
        for (const auto kind : measure.kinds) names.push_back(name(kind));
    return names;
}

bool names(const std::vector<Measure>& measures, MeasureKind kind) {
    return std::any_of(measures.begin(), measures.end(),
                       [kind](const Measure& measure) { return measure.kinds == std::vector{kind}; });
}

void expect_all_to_work(const model::Project& project, const std::vector<Measure>& measures) {
    for (const auto& measure : measures) {
        auto changed = project;
        measure.apply(changed);
        const auto line = proved(changed).at(measure.line);
        EXPECT_TRUE(line.feasible) << name(measure.kinds.front());
        EXPECT_EQ(line.utilization, measure.utilization_after);
        EXPECT_FALSE(measure.changes.empty());
        EXPECT_LE(measure.after, measure.deadline);
        const bool late = std::any_of(line.jobs.begin(), line.jobs.end(),
                                      [](const JobBound& job) { return job.late_with_fault(); });
        EXPECT_FALSE(late && measure.goal == Goal::with_faults);
    }
}

model::Project golden_project(std::size_t index) {
    return project_of(golden::sets()[index]);
}

TEST(Measures, AFeasibleProjectNeedsNone) {
    EXPECT_TRUE(measures_of(golden_project(2)).empty());
    for (const auto& finding : verdict_of(golden_project(2))) EXPECT_EQ(finding.severity, Severity::warning);
}

TEST(Measures, ALongReadThatBlocksIsSplit) {
    const auto project = golden_project(1);
    const auto found = measures_of(project);
    ASSERT_FALSE(found.empty());
    EXPECT_TRUE(names(found, MeasureKind::splitting));
    expect_all_to_work(project, found);
    const auto& split = found.front();
    EXPECT_EQ(split.kinds, std::vector{MeasureKind::splitting});
    EXPECT_TRUE(split.only_plan());
    EXPECT_EQ(split.before, 117'721us);
    EXPECT_EQ(split.deadline, 100ms);
    EXPECT_EQ(split.changes.front().key, "registers_per_request");
    EXPECT_EQ(split.changes.front().from, "60");
    EXPECT_EQ(split.changes.front().to, "30");
}

TEST(Measures, ASlowLineGetsTheNextBitRateThatHolds) {
    const auto project = golden_project(4);
    const auto found = measures_of(project);
    ASSERT_TRUE(names(found, MeasureKind::bit_rate));
    expect_all_to_work(project, found);
    const auto faster = std::find_if(found.begin(), found.end(), [](const Measure& measure) {
        return measure.kinds == std::vector{MeasureKind::bit_rate};
    });
    EXPECT_EQ(faster->changes.front().to, "19200");
}

TEST(Measures, OneByOneIsGrouped) {
    auto project = test::project({.strategy = model::Strategy::single}, row(16, int16(0).read(3)));
    project.lines[0].devices[0].turnaround = 5ms;
    const auto found = measures_of(project);
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found.front().kinds, std::vector{MeasureKind::grouping});
    EXPECT_EQ(found.front().changes.front().key, "group_requests");
    EXPECT_FALSE(found.front().before);  // overloaded
    expect_all_to_work(project, found);
}

TEST(Measures, AnUnknownTurnaroundIsToBeMeasured) {
    auto project = test::project({}, {int16(0).read(3).every(100ms), int16(100).read(3).every(100ms)});
    project.lines[0].devices[0].response_timeout = 400ms;
    const auto found = measures_of(project);
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found.front().kinds, std::vector{MeasureKind::turnarounds});
    EXPECT_EQ(found.front().changes.front().key, "turnaround");
    EXPECT_EQ(found.front().changes.front().from, "");
    EXPECT_FALSE(found.front().only_plan()) << "it is a property of the device";
    expect_all_to_work(project, found);
}

/// One device without a turnaround, which was measured.
model::Project measured_project(const model::MeasuredTimes& measured) {
    auto project = test::project({}, {int16(0).read(3).every(100ms), int16(100).read(3).every(100ms)});
    auto& device = project.lines[0].devices[0];
    device.response_timeout = 400ms;
    device.response_timeout_set = true;
    device.times.measured = measured;
    return project;
}

/// The values that measures propose for this key.
std::vector<std::string> proposed(const std::vector<Measure>& measures, std::string_view key) {
    std::vector<std::string> values;
    for (const auto& measure : measures)
        for (const auto& change : measure.changes)
            if (change.key == key) values.push_back(change.to);
    return values;
}

TEST(Measures, ATurnaroundBelowTheMeasuredOneIsNotProposed) {
    EXPECT_EQ(proposed(measures_of(measured_project({})), "turnaround"), std::vector<std::string>{"20ms"});
    const auto slow = measured_project({.exchanges = 618, .longest = 45ms, .p999 = 45ms});
    EXPECT_TRUE(proposed(measures_of(slow), "turnaround").empty());
    const auto late = measured_project({.exchanges = 618, .longest = 8ms, .late = 79, .lateness = 307ms});
    EXPECT_TRUE(proposed(measures_of(late), "turnaround").empty());
}

TEST(Measures, EachDeviceKeepsItsMeasuredTurnaround) {
    auto project = measured_project({});
    for (auto& variable : project.lines[0].devices[0].variables) variable.period = 140ms;
    auto slower = project.lines[0].devices[0];
    slower.address = UnitId{2};
    slower.times.measured = {.exchanges = 12, .longest = 21ms};
    project.lines[0].devices.push_back(slower);
    EXPECT_EQ(proposed(measures_of(project), "turnaround"), (std::vector<std::string>{"15ms", "30ms"}));
}

TEST(Measures, ATimeOutBelowTheMeasuredResponsesIsNotProposed) {
    auto project = measured_project({.exchanges = 618, .longest = 90ms, .p999 = 90ms});
    project.lines[0].devices[0].turnaround = 5ms;
    project.faults_set = true;
    for (auto& variable : project.lines[0].devices[0].variables) variable.period = 400ms;
    EXPECT_EQ(proposed(measures_of(project), "response_timeout"), std::vector<std::string>{"200ms"});
}

TEST(Measures, ATurnaroundThatIsLearntWasNotUnset) {
    auto project = measured_project({.exchanges = 12, .longest = 8ms, .p999 = 8ms});
    project.lines[0].devices[0].learn_turnaround = true;
    const auto found = measures_of(project);
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found.front().changes.front().key, "turnaround");
    EXPECT_EQ(found.front().changes.front().from, "learn");
}

TEST(Measures, GroupingAndAMeasuredTurnaroundComeFirstTogether) {
    std::vector<test::Item> variables;
    for (std::uint16_t i = 0; i < 60; ++i) variables.push_back(int16(i).read(3).every(100ms));
    auto project = test::project({}, variables);
    project.lines[0].devices[0].strategy = model::Strategy::single;
    project.lines[0].devices[0].response_timeout = 400ms;
    const auto found = measures_of(project);
    ASSERT_GE(found.size(), 2U);
    EXPECT_EQ(found[0].kinds, (std::vector{MeasureKind::grouping, MeasureKind::turnarounds}));
    EXPECT_EQ(found[1].kinds, std::vector{MeasureKind::periods});
    expect_all_to_work(project, found);
}

TEST(Measures, FaultsThatAreTooMuchGetDerivedTimeOuts) {
    auto project = golden_project(3);
    project.derive_timeouts = false;
    EXPECT_TRUE(measures_of(project).empty());
    project.faults_set = true;
    const auto found = measures_of(project);
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found.front().kinds, std::vector{MeasureKind::time_outs});
    EXPECT_EQ(found.front().goal, Goal::with_faults);
    EXPECT_EQ(found.front().changes.front().key, "derive_timeouts");
    expect_all_to_work(project, found);
    const auto findings = verdict_of(project);
    ASSERT_FALSE(findings.empty());
    EXPECT_EQ(findings.front().code, "guarantee.late_with_fault");
    EXPECT_EQ(findings.front().severity, Severity::warning);
}

TEST(Measures, PeriodsThatAreTooShortAreLengthened) {
    auto project = test::project({.framing = wire::Framing::tcp}, {int16(0).read(3).every(3ms)});
    project.lines[0].devices[0].turnaround = 4ms;
    const auto found = measures_of(project);
    ASSERT_EQ(kinds_of(found), (std::vector<std::string_view>{"periods"}));
    EXPECT_EQ(found.front().changes.front().path, "lines[0].devices[0].variables[0]");
    EXPECT_EQ(found.front().changes.front().from, "3ms");
    expect_all_to_work(project, found);
}

TEST(Measures, FewerAttemptsAtADeadDevice) {
    auto project = golden_project(2);
    project.lines[0].devices[1].attempts = 30;
    EXPECT_TRUE(measures_of(project).empty());
    const auto found = measures_of(project, true);
    ASSERT_TRUE(names(found, MeasureKind::attempts));
    expect_all_to_work(project, found);
}

model::Project overloaded_by_one() {
    auto made = test::project(
        {}, {int16(0).read(3).every(10ms), int16(50).read(3).every(50ms), int16(100).read(3).every(50ms)});
    made.lines[0].devices[0].turnaround = 5ms;
    return made;
}

// On an overloaded line the request with the largest share comes before a higher bit rate.
TEST(Measures, TheLargestShareIsNamedFirst) {
    const auto project = overloaded_by_one();
    const auto found = measures_of(project);
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found[0].kinds, std::vector{MeasureKind::periods});
    ASSERT_EQ(found[0].changes.size(), 1U);
    EXPECT_EQ(found[0].changes[0].path, "lines[0].devices[0].variables[0]");
    EXPECT_NEAR(found[0].largest_share, 0.8, 0.05);
    expect_all_to_work(project, found);
}

// 115200 bit/s: the longest relayed request takes 0.15 s, and one goes ahead of polling 1 s after another.
TEST(Measures, ALineThatRelaysIsRelievedOfIt) {
    auto project = test::project({}, {int16(0).read(3).every(200ms)});
    auto& line = project.lines[0];
    line.devices[0].turnaround = 60ms;
    line.devices[0].variables[0].deadline = 300ms;
    line.relayed = model::SharedLine{.response_timeout = 60ms};
    line.relay_interval = 10ms;
    ASSERT_GT(proved(project)[0].utilization, 1);
    const auto found = measures_of(project);
    ASSERT_TRUE(names(found, MeasureKind::relay_interval));
    EXPECT_EQ(found[0].kinds, std::vector{MeasureKind::relay_interval});
    EXPECT_EQ(found[0].changes[0].key, "relay_interval");
    EXPECT_EQ(found[0].changes[0].from, "10ms");
    EXPECT_EQ(found[0].changes[0].path, "lines[0]");
    expect_all_to_work(project, found);
    line.relayed.reset();
    EXPECT_FALSE(names(measures_of(project), MeasureKind::relay_interval));
}

TEST(Measures, TwoTogetherWhereNoneIsEnough) {
    // So many registers that no bit rate carries them one by one, and no grouping carries them at this one.
    auto project = test::project({.strategy = model::Strategy::single}, row(125, int16(0).read(3)));
    auto& line = project.lines[0];
    line.format.baud = 2400;
    line.devices[0].turnaround = 5ms;
    for (auto& variable : line.devices[0].variables) variable.deadline = 100ms;  // none may be slower
    const auto found = measures_of(project);
    ASSERT_EQ(kinds_of(found), (std::vector<std::string_view>{"grouping", "bit_rate"}));
    expect_all_to_work(project, found);
    EXPECT_FALSE(found.front().only_plan());
}

// Findings
// -----------------------------------------------------------------------------------------------------

constexpr Duration kUnknown = Duration::min();

/// 20 requests of about 20 ms bus time every 100 ms, or every 2 s.
model::Project line_of(Duration turnaround, Duration period, std::optional<Duration> deadline = {}) {
    auto project = test::project({.registers_per_request = 2}, row(40, int16(0).read(3).every(period)));
    auto& device = project.lines[0].devices[0];
    device.response_timeout = 100ms;
    if (turnaround != kUnknown) device.turnaround = turnaround;
    device.variables[3].deadline = deadline;
    return project;
}

std::optional<Severity> worst_of(const std::vector<model::Finding>& findings) {
    std::optional<Severity> worst;
    for (const auto& finding : findings) worst = std::max(worst, std::optional(finding.severity));
    return worst;
}

// The table of docs/guarantees.md, "The verdict".
TEST(GuaranteeFindings, ThreeLevels) {
    struct Case {
        const char* what;
        model::Project project;
        Verdict verdict;
        std::optional<Severity> severity;
        std::string_view code;
    };
    auto owen = line_of(kUnknown, 100ms);
    owen.profile = model::Profile::owen_kc1;
    const Case cases[] = {
        {"time enough", line_of(10ms, 20s), Verdict::holds, {}, ""},
        {"time enough even with the time-out", line_of(kUnknown, 20s), Verdict::holds, {}, ""},
        {"overloaded", line_of(10ms, 100ms), Verdict::cannot_hold, Severity::error,
         "guarantee.overload_grouped"},
        {"overloaded by the estimate", line_of(kUnknown, 100ms), Verdict::cannot_hold, Severity::error,
         "guarantee.overload_grouped"},
        {"overloaded as the source of the profile allows", owen, Verdict::cannot_hold, Severity::warning,
         "guarantee.overload_grouped"},
        {"only the time-out is too long", line_of(kUnknown, 2s), Verdict::response_unknown, Severity::note,
         "guarantee.response_unknown"},
        {"an own deadline", line_of(10ms, 20s, 10ms), Verdict::cannot_hold, Severity::error,
         "guarantee.late"},
        {"an own deadline, nothing known", line_of(kUnknown, 20s, 10ms), Verdict::cannot_hold,
         Severity::error, "guarantee.late"},
        {"late without overload", golden_project(1), Verdict::not_proved, Severity::warning,
         "guarantee.late"},
    };
    for (const auto& [what, project, expected, severity, code] : cases) {
        const Plan plan = make_plan(project);
        EXPECT_EQ(verdict(project, plan.lines[0], proved(project)[0]), expected) << what;
        const auto findings = verdict_of(project);
        EXPECT_EQ(worst_of(findings), severity) << what;
        ASSERT_EQ(findings.empty(), code.empty()) << what;
        if (!findings.empty()) {
            EXPECT_EQ(findings.front().code, code) << what;
        }
        const auto strict = verdict_of(project, true);
        EXPECT_EQ(worst_of(strict),
                  expected == Verdict::holds ? std::nullopt : std::optional(Severity::error))
            << what;
    }
}

// turnaround: learn. A measured maximum takes the place of the time-out; it is no proof, so never a warning.
TEST(GuaranteeFindings, AMeasuredTurnaroundIsNotedAsMeasured) {
    auto project = line_of(kUnknown, 2s);
    auto& device = project.lines[0].devices[0];
    device.name = "Meter";
    device.learn_turnaround = true;
    const auto judged = [&](std::uint64_t exchanges, Duration longest) {
        device.times.measured = {.exchanges = exchanges, .longest = longest, .p999 = longest / 2};
        return verdict(project, make_plan(project).lines[0], proved(project)[0]);
    };
    EXPECT_EQ(judged(99, 10ms), Verdict::response_unknown) << "too few exchanges";
    EXPECT_EQ(verdict_of(project)[0].code, "guarantee.response_learning") << "the advice is followed already";

    EXPECT_EQ(judged(3120, 10ms), Verdict::holds);
    const auto findings = verdict_of(project);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].code, "guarantee.response_measured");
    EXPECT_EQ(findings[0].severity, Severity::note);
    EXPECT_EQ(findings[0].value, "10 ms");
    EXPECT_EQ(findings[0].arguments[1].second, "Meter");
    EXPECT_EQ(findings[0].arguments[2].second, "3120");
    EXPECT_EQ(findings[0].arguments[3].second, "1040") << "the rule of three";

    // 17 requests of 103 ms every 2 s fit only without the one that may block them, and the check of each
    // second.
    for (std::size_t slow = 34; slow < 40; ++slow) device.variables[slow].period = 60s;
    EXPECT_EQ(judged(3120, 100ms), Verdict::response_unknown) << "the maximum is too long, p99.9 is not";
    EXPECT_EQ(worst_of(verdict_of(project)), Severity::note);
    EXPECT_EQ(verdict_of(project).front().code, "guarantee.late");
    EXPECT_EQ(worst_of(verdict_of(project, true)), Severity::error) << "--prove";
}

TEST(GuaranteeFindings, ANoteNamesTheDevicesAndTheEstimatedLoad) {
    auto project = line_of(kUnknown, 2s);
    auto& devices = project.lines[0].devices;
    devices[0].name = "A";
    for (const char* const name : {"B", "C", "D"}) {
        devices.push_back(devices[0]);
        devices.back().name = name;
        devices.back().address = UnitId{static_cast<std::uint8_t>(devices.size())};
        devices.back().variables.clear();
    }
    devices[1].turnaround = 5ms;
    const auto names_in = [&] { return verdict_of(project).front().arguments[1].second; };
    EXPECT_EQ(names_in(), "A, C, D");
    EXPECT_EQ(verdict_of(project).front().arguments[2].second.back(), '%');
    devices[1].turnaround.reset();
    EXPECT_EQ(names_in(), "A, B, C, … (4)");
}

TEST(GuaranteeFindings, NamesTheVariablesAndByHowMuch) {
    auto project = golden_project(1);
    const auto findings = verdict_of(project);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].arguments.front().second, "v1, v2") << "both of the fast loop, in one request";
    EXPECT_EQ(findings[0].code, "guarantee.late");
    EXPECT_EQ(findings[0].severity, Severity::warning);
    EXPECT_EQ(findings[0].path, "lines[0].devices[1].variables[0]");
    EXPECT_EQ(findings[0].value, "117.721 ms");
    EXPECT_EQ(findings[0].allowed, "100 ms");
    EXPECT_EQ(findings[0].arguments.back().second, "17.721 ms");
}

// Eight alarm bits of one register, beside a long read that blocks them.
TEST(GuaranteeFindings, ARequestHasOneFinding) {
    std::vector<Item> items;
    for (int bit = 0; bit < 8; ++bit) items.push_back(boolean(500, bit).read(3).every(20ms));
    for (const Item& slow : row(100, int16(0).read(3).every(2s))) items.push_back(slow);
    auto project = test::project({.registers_per_request = 125, .strategy = model::Strategy::optimal}, items);
    project.lines[0].devices[0].turnaround = 5ms;
    const auto late = verdict_of(project);
    ASSERT_EQ(late.size(), 1U);
    EXPECT_EQ(late[0].code, "guarantee.late");
    EXPECT_EQ(late[0].path, "lines[0].devices[0].variables[0]");
    EXPECT_EQ(late[0].arguments.front().second, "v1, v2, v3, … v8 (8)");
    project.lines[0].devices[0].variables[3].deadline = 10ms;
    const auto demanded = verdict_of(project);
    ASSERT_EQ(demanded.size(), 1U) << "the error includes those of which lateness would be a warning";
    EXPECT_EQ(demanded[0].severity, Severity::error);
    EXPECT_EQ(demanded[0].allowed, "10 ms");
    EXPECT_EQ(demanded[0].path, "lines[0].devices[0].variables[3]");
}

TEST(GuaranteeFindings, AnOverloadNamesTheLargestShare) {
    auto project = test::project({}, {int16(0).read(3).every(4ms), int16(50).read(3).every(50ms)});
    project.lines[0].devices[0].turnaround = 5ms;
    const auto findings = verdict_of(project);
    ASSERT_FALSE(findings.empty());
    ASSERT_EQ(findings[0].code, "guarantee.overload_grouped");
    EXPECT_EQ(findings[0].arguments[2].second, "v1");
    EXPECT_EQ(findings[0].arguments[3].second, "Device16");
}

TEST(GuaranteeFindings, IsBoundedAndSaysHowManyMore) {
    const auto findings = verdict_of(line_of(10ms, 100ms), true);
    std::size_t of_variables = 0;
    for (const auto& finding : findings)
        of_variables += finding.code == "guarantee.late" || finding.code == "guarantee.unbounded" ? 1U : 0U;
    EXPECT_EQ(of_variables, 9U);
    EXPECT_EQ(findings.front().code, "guarantee.overload_grouped");
    EXPECT_EQ(findings.back().code, "guarantee.more");
}

TEST(GuaranteeFindings, EveryCodeHasItsTexts) {
    for (const auto language : text::kLanguages)
        for (const auto code : guarantee_finding_codes()) {
            EXPECT_TRUE(text::has(language, code)) << code;
            EXPECT_TRUE(text::has(language, std::string(code) + ".advice")) << code;
        }
}

TEST(GuaranteeFindings, ReportsAWriteWithoutARateLimit) {
    auto project = test::project({}, {int16(0).write(0x10).on_change()});
    const auto findings = verdict_of(project);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].code, "guarantee.unlimited");
    EXPECT_EQ(findings[0].severity, Severity::note);
}

TEST(GuaranteeFindings, ReportsBoundsThatAreLargerThanExactOnes) {
    const auto project = golden_project(0);
    const Plan plan = make_plan(project);
    auto lines = guarantee(project, plan);
    EXPECT_TRUE(lines[0].exact);
    Effort none{.most = 0};
    const auto rough = guarantee_line(project, project, plan.lines[0], {}, Scope::everything, &none);
    EXPECT_FALSE(rough.exact);
    for (std::size_t r = 0; r < rough.requests.size(); ++r) {
        const auto& bound = rough.requests[r].response;
        EXPECT_TRUE(!bound || *bound >= *lines[0].requests[r].response);
    }
    const auto exact = guarantee_findings(project, plan, lines, false);
    lines[0] = rough;
    const auto findings = guarantee_findings(project, plan, lines, false);
    const auto is_rough = [](const auto& finding) { return finding.code == "guarantee.rough"; };
    EXPECT_TRUE(std::ranges::none_of(exact, is_rough));
    EXPECT_EQ(std::ranges::count_if(findings, is_rough), 1);
}

}  // namespace measures_test
}  // namespace takt::plan
