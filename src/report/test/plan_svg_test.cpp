#include "takt/report/plans/plan_svg.hpp"

#include <gtest/gtest.h>

#include "sample.hpp"
#include "takt/report/drawing/svg.hpp"

namespace takt::report {
namespace plan_svg_test {

using namespace test;

std::string picture_of(const model::Project& project, text::Language language = text::Language::english,
                       const std::string& name = "sample.yaml") {
    return plan_svg(Texts(language), name, project, plan::make_plan(project));
}

std::string without_style_sheet(const std::string& svg) {
    const auto begin = svg.find("<style>");
    const auto end = svg.find("</style>");
    return svg.substr(0, begin) + svg.substr(end);
}

TEST(PlanSvg, IsWellFormedInEveryLanguage) {
    const auto project = project_of(kBoiler);
    const char* const codes[] = {"en", "ru", "uk"};
    for (std::size_t i = 0; i < kLanguages.size(); ++i) {
        const Texts texts(kLanguages[i]);
        const auto svg = picture_of(project, kLanguages[i]);
        EXPECT_TRUE(well_formed(svg));
        expect_contains(svg, "xml:lang=\"" + std::string(codes[i]) + '"');
        expect_contains(svg, xml_text(texts("app.svg.title", {{"file", "sample.yaml"}})));
        expect_contains(svg, xml_text(texts("app.svg.axis")));
        expect_contains(svg, "Котёл · 16");
        expect_complete(without_style_sheet(svg));
    }
}

TEST(PlanSvg, ABarForEachRequestWithItsParts) {
    const auto project = project_of(kBoiler);
    const auto plan = plan::make_plan(project);
    const auto svg = picture_of(project);
    for (std::size_t i = 0; i < plan.lines[0].requests.size(); ++i)
        if (plan.lines[0].requests[i].period)
            expect_contains(svg, "data-request=\"" + std::to_string(i) + '"');
    for (const char* part : {"silence", "request", "turnaround", "response"})
        expect_contains(svg, "<rect class=\"" + std::string(part) + '"');
    expect_contains(svg, "data-strip=\"enlarged\"");
}

TEST(PlanSvg, NamesAreEscaped) {
    auto project = project_of(kBoiler);
    project.lines[0].name = "<script>&\"'";
    project.lines[0].devices[0].name = "a<b>&c";
    project.lines[0].devices[0].variables[0].name = "\x01\xFF";
    const auto svg = picture_of(project, text::Language::english, "</svg><x>");
    EXPECT_TRUE(well_formed(svg));
    EXPECT_EQ(svg.find("<script>"), std::string::npos);
    expect_contains(svg, "a&lt;b&gt;&amp;c · 16");
    expect_contains(svg, "&lt;/svg&gt;&lt;x&gt;");
    EXPECT_EQ(count_of(svg, "</svg>"), 1U);
}

TEST(PlanSvg, LongNamesAreCut) {
    auto project = project_of(kBoiler);
    project.lines[0].name = std::string(10000, 'x');
    project.lines[0].devices[0].name = std::string(10000, 'y');
    const auto svg = picture_of(project);
    EXPECT_TRUE(well_formed(svg));
    EXPECT_EQ(svg.find(std::string(200, 'x')), std::string::npos);
    expect_contains(svg, "… · 16");
}

TEST(PlanSvg, ALateRequestIsMarkedAndInTheLegend) {
    const auto svg = picture_of(project_of(overloaded()));
    EXPECT_TRUE(well_formed(svg));
    expect_contains(svg, "<rect class=\"late\"");
    expect_contains(svg, english()("app.svg.late"));
    EXPECT_EQ(picture_of(project_of(kBoiler)).find(english()("app.svg.late")), std::string::npos);
}

TEST(PlanSvg, NothingToDraw) {
    const auto empty = picture_of({});
    EXPECT_TRUE(well_formed(empty));
    EXPECT_EQ(empty.find("data-strip"), std::string::npos);
    expect_contains(picture_of(project_of(kEmptyLine)), english()("app.svg.nothing"));
}

TEST(PlanSvg, HugeProjectsAreLimitedAndSaySo) {
    auto project = project_of(kBoiler);
    const auto line = project.lines[0];
    for (int i = 1; i < 60; ++i) project.lines.push_back(line);
    const auto lines = picture_of(project);
    EXPECT_TRUE(well_formed(lines));
    expect_contains(lines, english()("app.svg.more_lines", {{"count", "20"}}));
    EXPECT_EQ(lines.find("data-line=\"40\""), std::string::npos);

    project.lines.resize(1);
    auto& devices = project.lines[0].devices;
    const auto device = devices[0];
    for (int i = 1; i < 100; ++i) {
        devices.push_back(device);
        devices.back().address = UnitId{static_cast<std::uint8_t>(i)};
        devices.back().poll_period = std::chrono::seconds(60);
        for (auto& variable : devices.back().variables)
            if (variable.period != Duration::zero()) variable.period = std::chrono::seconds(60);
    }
    const auto rows = picture_of(project);
    EXPECT_TRUE(well_formed(rows));
    expect_contains(rows, english()("app.svg.more_devices", {{"count", "36"}}));
    EXPECT_LT(rows.size(), 4U << 20U);
}

}  // namespace plan_svg_test
}  // namespace takt::report
