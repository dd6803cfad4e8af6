#include "takt/report/plans/findings_report.hpp"

#include <gtest/gtest.h>

#include "sample.hpp"

namespace takt::report {
namespace findings_report_test {

using namespace test;

const std::vector<std::string> kFiles{"plant.yaml", "котёл.csv"};

model::Finding finding(std::uint32_t file, std::uint32_t line, std::uint32_t column) {
    model::Finding made;
    made.severity = model::Severity::error;
    made.code = "field.range";
    made.location = {file, line, column};
    made.path = "lines[0].baud";
    made.value = "7";
    made.allowed = "50..4000000";
    return made;
}

TEST(FindingsReport, ALineInTheFormOfACompiler) {
    const std::vector findings{finding(0, 12, 5)};
    const auto text = findings_text(english(), kFiles, findings);
    EXPECT_TRUE(text.starts_with("plant.yaml:12:5: error: lines[0].baud: ")) << text;
    EXPECT_TRUE(text.ends_with('\n'));
    expect_contains(text, english().message(findings[0]));
}

TEST(FindingsReport, LocationsThatAreNotComplete) {
    const struct {
        std::uint32_t file, line;
        const char* begin;
    } cases[] = {{1, 3, "котёл.csv:3:1: "}, {0, 0, "plant.yaml: error: "}, {9, 4, "?:4:1: "}, {9, 0, "?: "}};
    for (const auto& c : cases) {
        const auto text = findings_text(english(), kFiles, std::vector{finding(c.file, c.line, 1)});
        EXPECT_TRUE(text.starts_with(c.begin)) << text;
    }
    EXPECT_TRUE(findings_text(english(), {}, std::vector{finding(0, 1, 1)}).starts_with("?:1:1: "));
}

TEST(FindingsReport, SeverityAndAdviceInEveryLanguage) {
    auto warning = finding(0, 1, 1);
    warning.severity = model::Severity::warning;
    warning.path.clear();
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = findings_text(texts, kFiles, std::vector{finding(0, 1, 1), warning});
        expect_contains(text, ": " + texts("app.error") + ": lines[0].baud: ");
        expect_contains(text, ": " + texts("app.warning") + ": " + texts.message(warning));
        const auto advice = texts.advice(warning);
        EXPECT_EQ(count_of(text, "\n    " + advice + '\n'), advice.empty() ? 0U : 2U);
    }
}

TEST(FindingsReport, AnAdviceThatRepeatsIsShownOnce) {
    std::vector findings{finding(0, 12, 5), finding(0, 13, 5), finding(0, 14, 5)};
    for (auto& each : findings) each.code = "variable.bit_assumed";
    const auto advice = english().advice(findings[0]);
    ASSERT_FALSE(advice.empty());
    EXPECT_EQ(count_of(findings_text(english(), kFiles, findings), advice), 1U);
    findings[1].code = "variable.scale_zero";
    EXPECT_EQ(count_of(findings_text(english(), kFiles, findings), advice), 2U) << "another one is between";
}

TEST(FindingsReport, NoFindings) {
    EXPECT_EQ(findings_text(english(), kFiles, {}), "");
    EXPECT_EQ(findings_json(english(), kFiles, {}).dump(), "[]");
}

TEST(FindingsReport, TheObjectOfACheck) {
    host::LoadedFile loaded;
    EXPECT_EQ(check_json(english(), loaded).dump(), R"({"findings":[]})");
    loaded.files = kFiles;
    loaded.findings = {finding(1, 3, 4)};
    EXPECT_EQ(check_json(english(), loaded).dump(),
              R"({"findings":)" + findings_json(english(), loaded).dump() + '}');
}

TEST(FindingsReport, JsonKeepsCodeAndLocation) {
    const std::vector findings{finding(1, 3, 4), finding(9, 0, 0)};
    const auto list = findings_json(english(), kFiles, findings);
    ASSERT_EQ(size_of(list), 2U);
    EXPECT_JSON(at(list, 0, "severity"), "error");
    EXPECT_JSON(at(list, 0, "code"), "field.range");
    EXPECT_JSON(at(list, 0, "file"), "котёл.csv");
    EXPECT_JSON(at(list, 0, "line"), 3U);
    EXPECT_JSON(at(list, 0, "column"), 4U);
    EXPECT_JSON(at(list, 0, "value"), "7");
    EXPECT_JSON(at(list, 0, "allowed"), "50..4000000");
    EXPECT_JSON(at(list, 0, "message"), english().message(findings[0]));
    EXPECT_JSON(at(list, 1, "file"), "") << "of an unknown file";
}

TEST(FindingsReport, JsonEscapesWhatTheUserWrote) {
    auto odd = finding(0, 1, 1);
    odd.value = "a\"b\\c\n\x01\xFF";
    const auto text = findings_json(english(), kFiles, std::vector{odd}).dump();
    const auto back = file::Json::parse(text);
    ASSERT_TRUE(back) << text;
    EXPECT_JSON(at(*back, 0, "value"), "a\"b\\c\n\x01\xEF\xBF\xBD");
}

TEST(FindingsReport, TheSummaryCountsBySeverity) {
    auto warning = finding(0, 1, 1);
    warning.severity = model::Severity::warning;
    auto note = warning;
    note.severity = model::Severity::note;
    const std::vector findings{finding(0, 1, 1), warning, warning, note, note, note};
    for (const auto language : kLanguages) {
        const Texts texts(language);
        EXPECT_EQ(findings_summary(texts, "plant.yaml", findings),
                  texts("app.checked",
                        {{"file", "plant.yaml"}, {"errors", "1"}, {"warnings", "2"}, {"notes", "3"}}) +
                      '\n');
        expect_complete(findings_summary(texts, "plant.yaml", {}));
    }
}

TEST(FindingsReport, ManyFindings) {
    const std::vector<model::Finding> findings(5000, finding(0, 1, 1));
    EXPECT_GE(count_of(findings_text(english(), kFiles, findings), "plant.yaml:1:1"), 5000U);
    EXPECT_EQ(size_of(findings_json(english(), kFiles, findings)), 5000U);
}

}  // namespace findings_report_test
}  // namespace takt::report
