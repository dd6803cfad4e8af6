#include "takt/report/plans/outlook_report.hpp"

#include <gtest/gtest.h>

#include "sample.hpp"

namespace takt::report {
namespace outlook_report_test {

using namespace test;
using namespace std::chrono_literals;

Outlook outlook_of(const model::Project& project) {
    return outlook(project, plan::prove(project, false, false));
}

TEST(OutlookReport, OneLine) {
    const auto project = project_of(kBoiler);
    const auto made = outlook_of(project);
    const auto proof = plan::prove(project, false, false);
    EXPECT_EQ(made.lines, 1U);
    EXPECT_EQ(made.requests, proof.plan.lines[0].request_count);
    EXPECT_EQ(made.cycle, proof.plan.lines[0].cycle);
    ASSERT_TRUE(made.oldest);
    EXPECT_EQ(made.oldest_name, "Pump") << "it is polled once a second, the others twice";
    EXPECT_EQ(made.oldest, proof.lines[0].ages[0][5]);
    for (const auto language : kLanguages) {
        const auto text = outlook_text(Texts(language), project, made);
        expect_contains(text, "(Pump)");
        expect_complete(text);
        EXPECT_EQ(text.find("rs485-1"), std::string::npos) << "there is only one line";
    }
}

TEST(OutlookReport, TheFiguresOfSeveralLinesNameTheirs) {
    auto project = project_of(kBoiler);
    project.lines.push_back(project.lines[0]);
    project.lines[1].name = "slow";
    project.lines[1].format.baud = 1200;
    const auto made = outlook_of(project);
    EXPECT_EQ(made.lines, 2U);
    EXPECT_EQ(made.slowest, 1U);
    EXPECT_EQ(made.busiest, 1U);
    expect_contains(outlook_text(english(), project, made), " % (slow)");
}

TEST(OutlookReport, AnAgeThatIsNotProvedIsNotGiven) {
    const auto project = project_of(overloaded());
    const auto made = outlook_of(project);
    EXPECT_FALSE(made.oldest);
    EXPECT_JSON(at(outlook_json(made), "oldest_us"), file::Json());
    expect_contains(outlook_text(english(), project, made), english()("app.outlook.not_proved"));
}

TEST(OutlookReport, AProjectWithoutRequestsHasNone) {
    const auto project = project_of(kEmptyLine);
    EXPECT_EQ(outlook_text(english(), project, outlook_of(project)), "");
}

}  // namespace outlook_report_test
}  // namespace takt::report
