#include "takt/report/states/learnt_report.hpp"

#include <gtest/gtest.h>

#include "sample.hpp"

namespace takt::report {
namespace learnt_report_test {

using namespace test;
using namespace std::chrono_literals;

constexpr auto kHolding = static_cast<std::size_t>(wire::Area::holding_register);

/// Registers 0, 4 and 9 are polled; 1..3 and 5..8 are gaps.
model::Project learning() {
    return project_of(R"(takt: 1
lines:
  - name: rs485-1
    transport: serial
    port: /dev/ttyS1
    devices:
      - name: Насос
        address: 7
        strategy: optimal
        gaps: learn
        group_requests: true
        variables:
          - {name: a, type: int16, register: 0, read: 0x03}
          - {name: b, type: int16, register: 4, read: 0x03}
          - {name: c, type: int16, register: 9, read: 0x03}
)");
}

TEST(LearntReport, NothingWhereNothingLearns) {
    const auto project = project_of(kBoiler);
    EXPECT_EQ(learnt_text(english(), project, 0), "");
    EXPECT_EQ(learnt_json(project, 0).dump(), "[]");
}

TEST(LearntReport, GapsToBeTried) {
    const auto project = learning();
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = learnt_text(texts, project, 0);
        expect_complete(text);
        expect_contains(text, "Насос 0x03: " + texts("app.learnt.untried_items", {{"items", "1..3, 5..8"}}));
    }
    EXPECT_EQ(at(learnt_json(project, 0), 0, "untried").dump(),
              R"([{"first":1,"last":3},{"first":5,"last":8}])");
}

TEST(LearntReport, ConfirmedRefusedAndLimited) {
    auto project = learning();
    auto& learnt = project.lines[0].devices[0].learnt;
    learnt.confirmed[kHolding] = {{0, 4}};
    learnt.refused[kHolding] = {{.items = {5, 8}, .exception = 2, .since = 3h, .checked = 90min}};
    learnt.most_items[kHolding] = 16;
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = learnt_text(texts, project, 0);
        expect_complete(text);
        expect_contains(text, texts("app.learnt.confirmed_items", {{"items", "0..4"}}));
        expect_contains(text, texts.duration(90min));
        expect_contains(text, texts("app.learnt.most_items", {{"count", "16"}}));
        EXPECT_EQ(count_of(text, "\n"), 1U);
    }
    const auto json = learnt_json(project, 0);
    EXPECT_EQ(at(json, 0).dump(),
              R"({"device":"Насос","unit":7,"function":3,"confirmed":[{"first":0,"last":4}],)"
              R"("refused":[{"first":5,"last":8,"exception":2,"since_s":10800,"checked_s":5400}],)"
              R"("untried":[],"most_items":16})");
}

TEST(LearntReport, ALimitThatWasNotMetIsNull) {
    EXPECT_JSON(at(learnt_json(learning(), 0), 0, "most_items"), file::Json());
}

TEST(LearntReport, ManyRangesAreCutOffInTextOnly) {
    auto project = learning();
    auto& confirmed = project.lines[0].devices[0].learnt.confirmed[kHolding];
    for (int i = 0; i < 4000; ++i)
        confirmed.push_back(
            {static_cast<std::uint16_t>(1000 + 4 * i), static_cast<std::uint16_t>(1001 + 4 * i)});
    const auto text = learnt_text(english(), project, 0);
    expect_contains(text, "1044..1045, … (4000)");
    EXPECT_EQ(size_of(at(learnt_json(project, 0), 0, "confirmed")), 4000U);
}

}  // namespace learnt_report_test
}  // namespace takt::report
