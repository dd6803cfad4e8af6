// gaps: learn: the gaps to try, and the plan without them.
#include "takt/plan/learning.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "builder.hpp"
#include "takt/model/item_ranges.hpp"
#include "takt/plan/guarantee.hpp"

namespace takt::plan {
namespace learning_test {

using namespace test;
using namespace std::chrono_literals;

constexpr auto kHolding = static_cast<std::size_t>(wire::Area::holding_register);

model::Project learning(const std::vector<Item>& items) {
    auto made = project({.strategy = model::Strategy::optimal}, items);
    made.lines[0].devices[0].gaps = model::Gaps::learn;
    return made;
}

std::vector<std::pair<int, int>> reads(const LinePlan& plan) {
    std::vector<std::pair<int, int>> all;
    for (const auto& request : plan.requests)
        if (request.read) all.emplace_back(request.start, request.quantity);
    return all;
}

TEST(Learning, NothingConfirmedNothingBridged) {
    const auto described = learning({int16(0).read(3), real(4).read(3), int16(9).read(3)});
    const auto made = learning_plan(described, 0);
    EXPECT_EQ(reads(made.plan), (std::vector<std::pair<int, int>>{{0, 1}, {4, 2}, {9, 1}}));
    ASSERT_EQ(made.trials.size(), 1U);
    EXPECT_EQ(made.trials[0].gaps, (std::vector<Gap>{{{1, 3}, 0, 5}, {{6, 8}, 4, 9}}));
    EXPECT_FALSE(made.trials[0].refused);
}

TEST(Learning, WhatIsConfirmedIsReadAndNoLongerTried) {
    auto described = learning({int16(0).read(3), real(4).read(3), int16(9).read(3)});
    described.lines[0].devices[0].learnt.confirmed[kHolding] = {{0, 5}};
    const auto made = learning_plan(described, 0);
    EXPECT_EQ(reads(made.plan), (std::vector<std::pair<int, int>>{{0, 6}, {9, 1}}));
    ASSERT_EQ(made.trials.size(), 1U);
    EXPECT_EQ(made.trials[0].gaps, (std::vector<Gap>{{{6, 8}, 4, 9}}));
}

TEST(Learning, WhatIsRefusedIsNeverPlannedAndAskedForAlone) {
    auto described = learning({int16(0).read(3), real(4).read(3), int16(9).read(3)});
    auto& learnt = described.lines[0].devices[0].learnt;
    learnt.refused[kHolding] = {{.items = {1, 3}, .exception = 2}};
    EXPECT_EQ(reads(make_plan(described).lines[0]), (std::vector<std::pair<int, int>>{{0, 1}, {4, 6}}));
    EXPECT_EQ(make_plan(described).lines[0].requests[0].why.code, "plan.gap_forbidden");
    const auto made = learning_plan(described, 0);
    ASSERT_EQ(made.trials.size(), 2U);
    EXPECT_EQ(made.trials[0].gaps, (std::vector<Gap>{{{6, 8}, 4, 9}}));
    EXPECT_EQ(made.trials[1].gaps, (std::vector<Gap>{{{1, 3}, 0, 5}}));
    EXPECT_TRUE(made.trials[1].refused);
}

TEST(Learning, LongerReadsThanTheDeviceAnswersAreNotPlanned) {
    auto described = learning({int16(0).read(3), int16(4).read(3), int16(9).read(3), real(30).read(3)});
    described.lines[0].devices[0].learnt.most_items[kHolding] = 6;
    const auto plan = make_plan(described).lines[0];
    for (const auto& [start, quantity] : reads(plan)) EXPECT_LE(quantity, 6);
    EXPECT_EQ(plan.requests.size(), 3U);
    EXPECT_EQ(plan.requests[0].why.code, "plan.limit_learnt");
}

// 5..11 in one read is longer than the deadline of 5 allows others to be.
TEST(Learning, NoDeadlineThatHeldIsGivenUpForALongerRead) {
    auto described = learning(
        {int16(5).read(3).every(80ms), int16(11).read(3).every(500ms), int16(16).read(3).every(240ms)});
    auto& device = described.lines[0].devices[0];
    device.turnaround = 4ms;
    device.variables[0].deadline = 16ms;
    device.variables[1].deadline = device.variables[2].deadline = 23ms;
    const auto first = learning_plan(described, 0);
    ASSERT_TRUE(guarantee_line(described, first.plan).feasible);
    std::vector<model::Learnt> learnt(1);
    learnt[0].confirmed[kHolding] = {{5, 11}};
    EXPECT_EQ(reads(learning_plan(described, 0, learnt).plan), reads(first.plan));
    device.variables[0].deadline = 40ms;
    EXPECT_NE(reads(learning_plan(described, 0, learnt).plan), reads(first.plan))
        << "where there is time for it";
}

TEST(Learning, APlanWithNewResultsHasItsRefreshBounds) {
    auto described = learning({int16(0).read(3).every(100ms), int16(4).read(3).every(100ms)});
    described.lines[0].devices[0].turnaround = 4ms;
    std::vector<model::Learnt> learnt(1);
    learnt[0].confirmed[kHolding] = {{1, 3}};
    const auto made = learning_plan(described, 0, learnt).plan;
    ASSERT_EQ(made.requests.size(), 1U);
    described.lines[0].devices[0].learnt = learnt[0];
    const auto proved = guarantee_line(described, make_plan(described).lines[0]);
    ASSERT_TRUE(proved.feasible);
    const RefreshBound expected{100ms + *proved.requests[0].response, *proved.ages_with_failures[0][0]};
    EXPECT_EQ(made.requests[0].refresh_bound, expected);
}

TEST(Learning, OnlyWhatTheUserAllowsIsTried) {
    auto described = learning({int16(0).read(3), int16(4).read(3), int16(9).read(3)});
    described.lines[0].devices[0].no_read[kHolding] = {{2, 2}};
    const auto made = learning_plan(described, 0);
    ASSERT_EQ(made.trials.size(), 1U);
    EXPECT_EQ(made.trials[0].gaps, (std::vector<Gap>{{{5, 8}, 4, 9}}));
    described.lines[0].devices[0].gaps = model::Gaps::always;
    EXPECT_TRUE(learning_plan(described, 0).trials.empty());
}

// With any knowledge the plan that runs reads known gaps only, no trial asks for what is known, and together
// they are what would be read if all were well.
RC_GTEST_PROP(Learning, TriesExactlyWhatThePlanWouldBridge, ()) {
    std::vector<Item> items;
    int at = 0;
    for (int i = *rc::gen::inRange(1, 30); i > 0; --i) {
        at += *rc::gen::element(0, 0, 1, 2, 5, 12);
        items.push_back(int16(at++).read(3).every(*rc::gen::element(100ms, 100ms, 300ms)));
    }
    auto described = learning(items);
    auto& device = described.lines[0].devices[0];
    for (int i = *rc::gen::inRange(0, 4); i > 0; --i) {
        const auto first = static_cast<std::uint16_t>(*rc::gen::inRange(0, at));
        const model::ItemRanges known{{first, static_cast<std::uint16_t>(first + *rc::gen::inRange(0, 20))}};
        auto& confirmed = device.learnt.confirmed[kHolding];
        confirmed = model::united(confirmed, known);
    }
    const auto made = learning_plan(described, 0);
    const auto& confirmed = device.learnt.confirmed[kHolding];
    for (const auto& request : made.plan.requests)
        for (const auto& gap :
             gaps_in(device, *request.read,
                     {request.start, static_cast<std::uint16_t>(request.start + request.quantity - 1)}))
            RC_ASSERT(model::holds(confirmed, gap));
    model::ItemRanges tried;
    for (const auto& trial : made.trials)
        for (const auto& gap : trial.gaps) {
            RC_ASSERT(!model::holds(confirmed, gap.items));
            RC_ASSERT(gap.before < gap.items.first && gap.items.last < gap.after);
            RC_ASSERT(model::without({gap.items}, tried) == model::ItemRanges{gap.items});
            tried = model::united(tried, {gap.items});
        }
    const auto wanted = make_plan(described).lines[0];
    for (const auto& request : wanted.requests)
        for (const auto& gap :
             gaps_in(device, *request.read,
                     {request.start, static_cast<std::uint16_t>(request.start + request.quantity - 1)}))
            RC_ASSERT(model::holds(model::united(confirmed, tried), gap));
    device.learnt.confirmed[kHolding] = model::united(confirmed, tried);
    RC_ASSERT(reads(learning_plan(described, 0).plan) == reads(make_plan(described).lines[0]));
}

}  // namespace learning_test
}  // namespace takt::plan
