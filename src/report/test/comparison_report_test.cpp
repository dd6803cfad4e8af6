#include "takt/report/plans/comparison_report.hpp"

#include <gtest/gtest.h>

#include "sample.hpp"
#include "takt/report/drawing/text_table.hpp"

namespace takt::report {
namespace comparison_report_test {

using namespace test;
using namespace std::chrono_literals;

plan::Cost cost(std::size_t requests, double utilization) {
    return {.requests = requests,
            .bytes = 100 * requests,
            .bus_time = static_cast<std::int64_t>(requests) * 10ms,
            .cycle = static_cast<std::int64_t>(requests) * 10ms,
            .utilization = utilization,
            .requests_per_second = static_cast<double>(requests),
            .bytes_per_second = 100.0 * static_cast<double>(requests)};
}

plan::Comparison comparison() {
    plan::Comparison made;
    made.single = cost(10, 0.8);
    made.grouped = cost(4, 0.4);
    made.strategies[0] = {model::Strategy::single, cost(10, 0.8), {}};
    made.strategies[1] = {model::Strategy::classic, cost(5, 0.4), {.requests = 50, .utilization = 50}};
    made.strategies[2] = {model::Strategy::optimal, cost(4, 0.3), {.requests = 60, .utilization = 62.5}};
    made.configured = model::Strategy::classic;
    return made;
}

TEST(ComparisonReport, Savings) {
    const struct {
        double percent;
        const char* text;
    } cases[] = {{29, "-29 %"}, {-12, "+12 %"}, {0, "0 %"}, {0.4, "0 %"}, {-0.4, "0 %"}, {99.6, "-100 %"}};
    for (const auto& [percent, text] : cases) EXPECT_EQ(saving_text(percent), text);
}

TEST(ComparisonReport, RowsMarkTheStrategyOfThePlan) {
    const auto rows = compared_rows(english(), comparison());
    ASSERT_EQ(rows.size(), 3U);
    EXPECT_EQ(rows[0].name, "single");
    EXPECT_EQ(rows[0].saved, nullptr) << "nothing to compare it with";
    EXPECT_TRUE(rows[1].configured);
    EXPECT_FALSE(rows[2].configured);
    auto mixed = comparison();
    mixed.configured.reset();
    const auto more = compared_rows(english(), mixed);
    ASSERT_EQ(more.size(), 4U);
    EXPECT_EQ(more[3].name, english()("app.mixed"));
    EXPECT_EQ(more[3].style, "mixed");
    EXPECT_TRUE(more[3].configured);
}

TEST(ComparisonReport, ATableForEachLineInEveryLanguage) {
    const auto project = project_of(kBoiler);
    const auto plan = plan::make_plan(project);
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = comparison_text(texts, project, plan);
        expect_complete(text);
        expect_contains(text, "rs485-1");
        expect_contains(text, texts("app.requests"));
        expect_contains(text, texts("app.as_configured"));
        for (const char* strategy : {"single", "classic", "optimal"}) expect_contains(text, strategy);
        expect_contains(text, "█");
    }
}

TEST(ComparisonReport, TheWidestBarIsThatOfTheBusiestStrategy) {
    const auto project = project_of(kBoiler);
    const auto text = comparison_text(english(), project, plan::make_plan(project));
    std::size_t widest = 0;
    std::size_t single = 0;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        widest = std::max(widest, count_of(line, "█"));
        if (line.starts_with("single")) single = count_of(line, "█");
    }
    EXPECT_GT(single, 0U);
    EXPECT_EQ(single, widest);
}

TEST(ComparisonReport, BarsAreShorterOnANarrowTerminal) {
    const auto project = project_of(kBoiler);
    const auto plan = plan::make_plan(project);
    const auto wide = comparison_text(english(), project, plan);
    std::istringstream lines(wide);
    std::size_t widest = 0;
    for (std::string line; std::getline(lines, line);) widest = std::max(widest, display_width(line));
    EXPECT_EQ(comparison_text(english(), project, plan, widest), wide);
    const auto narrow = comparison_text(english(), project, plan, widest - 10);
    EXPECT_GT(count_of(wide, "█"), count_of(narrow, "█"));
    EXPECT_GT(count_of(narrow, "█"), 0U);
    std::istringstream cut(narrow);
    for (std::string line; std::getline(cut, line);) EXPECT_LE(display_width(line), widest - 10) << line;
    EXPECT_EQ(comparison_text(english(), project, plan, 1).find("█"), std::string::npos);
}

TEST(ComparisonReport, NothingPolledHasNoBars) {
    const auto project = project_of(kEmptyLine);
    const auto text = comparison_text(english(), project, plan::make_plan(project));
    EXPECT_EQ(text.find("█"), std::string::npos);
    EXPECT_EQ(comparison_text(english(), {}, {}), "");
}

TEST(ComparisonReport, Json) {
    const auto json = comparison_json(comparison());
    EXPECT_EQ(at(json, "grouped").dump(),
              R"({"requests":4,"bytes":400,"bus_time_us":40000,"cycle_us":40000,"utilization":0.4,)"
              R"("requests_per_second":4.0,"bytes_per_second":400.0})");
    EXPECT_JSON(at(json, "ungrouped", "requests"), 10U);
    EXPECT_JSON(at(json, "strategies", "optimal", "saved_percent", "utilization"), 62.5);
    EXPECT_JSON(at(json, "strategies", "classic", "requests"), 5U);
    EXPECT_JSON(at(json, "saved_percent", "requests"), 0.0);
}

}  // namespace comparison_report_test
}  // namespace takt::report
