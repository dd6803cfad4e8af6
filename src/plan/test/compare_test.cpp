#include "takt/plan/compare.hpp"

#include <gtest/gtest.h>

#include "builder.hpp"

namespace takt::plan {
namespace compare_test {

using namespace test;

// Scenario 1 (docs/specification.md, section 5) at 115200 8N1 with the estimated turnaround: one request of 8
// + 45 characters against ten of 8 + 9.
TEST(Compare, ShowsWhatScenario1Saves) {
    const auto made = project({125}, row(10, real(0).read(3)));
    const auto compared = compare(made, make_plan(made));
    ASSERT_EQ(compared.size(), 1U);
    const auto& [line, grouped, single, saved, strategies, configured] = compared[0];
    EXPECT_EQ(line, 0U);
    EXPECT_EQ(configured, model::Strategy::classic);
    EXPECT_EQ(grouped.requests, 1U);
    EXPECT_EQ(single.requests, 10U);
    EXPECT_DOUBLE_EQ(saved.requests, 90);
    EXPECT_EQ(grouped.bytes, 53U);
    EXPECT_EQ(single.bytes, 170U);
    EXPECT_NEAR(saved.bytes, 68.8235, 1e-4);
    EXPECT_EQ(grouped.bus_time, 11'350'695ns);
    EXPECT_EQ(single.bus_time, 82'256'945ns);
    EXPECT_EQ(grouped.cycle, grouped.bus_time);
    EXPECT_EQ(single.cycle, single.bus_time);
    EXPECT_NEAR(saved.bus_time, 86.2009, 1e-4);
    EXPECT_DOUBLE_EQ(saved.cycle, saved.bus_time);
}

TEST(Compare, SetsAllStrategiesBesideEachOther) {
    const auto made = project({125}, row(10, real(0).read(3)));
    const auto compared = compare(made, make_plan(made)).at(0);
    const auto& [single, classic, optimal] = compared.strategies;
    EXPECT_EQ(single.strategy, model::Strategy::single);
    EXPECT_EQ(single.cost.requests, 10U);
    EXPECT_EQ(single.saved.requests, 0);
    EXPECT_EQ(classic.strategy, model::Strategy::classic);
    EXPECT_EQ(classic.cost.requests, 1U);
    EXPECT_DOUBLE_EQ(classic.saved.requests, 90);
    EXPECT_EQ(optimal.strategy, model::Strategy::optimal);
    EXPECT_LE(optimal.cost.bus_time, classic.cost.bus_time);
    EXPECT_EQ(compared.configured, model::Strategy::classic);
}

TEST(Compare, ComparesRatesAsWell) {
    const auto made = project({125}, row(10, real(0).read(3)));
    const auto compared = compare(made, make_plan(made)).at(0);
    EXPECT_DOUBLE_EQ(compared.grouped.requests_per_second, 10);
    EXPECT_DOUBLE_EQ(compared.single.requests_per_second, 100);
    EXPECT_DOUBLE_EQ(compared.grouped.bytes_per_second, 530);
    EXPECT_DOUBLE_EQ(compared.saved.requests_per_second, 90);
    EXPECT_NEAR(compared.grouped.utilization, 0.11350695, 1e-7);
    EXPECT_NEAR(compared.saved.utilization, compared.saved.bus_time, 1e-4);
}

TEST(Compare, KnowsAPlanOfMixedStrategies) {
    auto made = project({125}, row(4, real(0).read(3)));
    auto alone = made.lines[0].devices[0];
    alone.address = UnitId{17};
    alone.strategy = model::Strategy::single;
    made.lines[0].devices.push_back(alone);
    const auto compared = compare(made, make_plan(made)).at(0);
    EXPECT_EQ(compared.configured, std::nullopt);
    EXPECT_EQ(compared.grouped.requests, 5U);
}

// Two entries that take turns at one stream, each half as often as the value is wanted.
TEST(Compare, SeesEntriesThatTakeTurns) {
    const auto made = project({125}, {int16(0).read(3), int16(9).read(3)});
    auto plan = make_plan(made);
    EXPECT_FALSE(compare(made, plan).at(0).takes_turns());
    auto& requests = plan.lines[0].requests;
    for (auto& request : requests) {
        request.stream = 3;
        request.period = 200ms;
    }
    requests[1].phase = 100ms;
    const auto compared = compare(made, plan).at(0);
    EXPECT_TRUE(compared.takes_turns());
    EXPECT_EQ(compared.configured, std::nullopt);
    EXPECT_DOUBLE_EQ(compared.grouped.requests_per_second, 10);
}

TEST(Compare, CountsAsScenario3Does) {
    const auto made = project({16}, {int16(500).read(3).read_on(0), int16(501).read(3).read_on(0),
                                     int16(506).read(4).read_on(1).every(50ms)});
    const auto compared = compare(made, make_plan(made));
    EXPECT_EQ(compared[0].grouped.requests, 4U);
    EXPECT_EQ(compared[0].single.requests, 6U);
    EXPECT_NEAR(compared[0].saved.requests, 33.3333, 1e-4);
}

TEST(Compare, KeepsWritesOutOfTheCycle) {
    const auto made = project({16}, row(3, int16(0).write(0x10).on_change()));
    const auto compared = compare(made, make_plan(made));
    EXPECT_EQ(compared[0].grouped.cycle, 0ns);
    EXPECT_GT(compared[0].grouped.bus_time, 0ns);
    EXPECT_EQ(compared[0].saved.cycle, 0);
    EXPECT_GT(compared[0].saved.bus_time, 0);
}

// One by one: 2 reads of 8 + 7 and 2 writes of 11 + 8 characters. Grouped: one read of 8 + 9; the writes stay
// apart, as the triggers differ.
TEST(Compare, WeighsMergedWritesAsThoseApart) {
    const auto made =
        project({16}, {int16(0).read(3).write(0x10).on_change(), int16(1).read(3).write(0x10).write_on(0)});
    const auto compared = compare(made, make_plan(made));
    EXPECT_EQ(compared[0].single.bytes, 2U * 15 + 2U * 19);
    EXPECT_EQ(compared[0].grouped.bytes, 17U + 2U * 19);
    EXPECT_GT(compared[0].saved.bus_time, 0);
}

// Bits of a register are written in entries of their own, an int in the entry that reads it: each is two.
TEST(Compare, CountsWritesOnBothSides) {
    auto made = project(
        {16}, {int16(0).read(3).write(6).on_change(), int16(1).read(3).write(6),
               boolean(2, 0).read(3).write(6).on_change(), boolean(2, 1).read(3).write(6).on_change()});
    made.lines[0].devices[0].read_modify_write = true;
    const auto plan = make_plan(made);
    const auto compared = compare(made, plan).at(0);
    EXPECT_EQ(plan.lines[0].request_count, 5U) << "two groups that read, three entries that write";
    EXPECT_EQ(compared.grouped.requests, 5U);
    EXPECT_EQ(compared.single.requests, 4U + 3);
    EXPECT_EQ(request_counts(made.lines[0], plan.lines[0]).ungrouped, compared.single.requests);
}

// A variable that only commands write is in a request of strategy `single` alone; no plan sends it.
TEST(Compare, CountsWritesOnlyWhereTheyAreSent) {
    const auto made = project({16}, row(3, int16(0).write(6)));
    const auto plan = make_plan(made);
    const auto compared = compare(made, plan).at(0);
    EXPECT_EQ(compared.single.requests, 0U);
    EXPECT_EQ(compared.single.bytes, 0U);
    EXPECT_EQ(compared.single.bus_time, 0ns);
    EXPECT_EQ(compared.saved.requests, 0);
    EXPECT_EQ(request_counts(made.lines[0], plan.lines[0]).ungrouped, 0U);
}

TEST(Compare, SavesNothingWithoutGrouping) {
    auto made = project({16}, row(3, int16(0).read(3)));
    made.lines.push_back(project({16}, {}).lines[0]);
    const auto compared = compare(made, make_plan(made, {.strategy = model::Strategy::single}));
    ASSERT_EQ(compared.size(), 2U);
    EXPECT_EQ(compared[0].saved.requests, 0);
    EXPECT_EQ(compared[0].saved.bus_time, 0);
    EXPECT_EQ(compared[1].line, 1U);
    EXPECT_EQ(compared[1].single.requests, 0U);
}

}  // namespace compare_test
}  // namespace takt::plan
