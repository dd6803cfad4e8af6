#include "takt/plan/shares.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "builder.hpp"

namespace takt::plan {
namespace shares_test {

using namespace test;

double sum(const std::vector<double>& shares) {
    return std::accumulate(shares.begin(), shares.end(), 0.0);
}

/// Two devices: one variable each 100 ms, and one with that period.
model::Project two_devices(Duration second) {
    auto made = project({}, {int16(0).read(3).every(100ms)});
    made.lines[0].devices.push_back(device(17, {}, {int16(0).read(3).every(second)}));
    return made;
}

TEST(Shares, AreBusTimePerPeriodAndAddUpToTheLoad) {
    const auto project = two_devices(400ms);
    const Plan plan = make_plan(project);
    const auto made = shares(project.lines[0], plan.lines[0]);
    ASSERT_EQ(made.requests.size(), 2U);
    EXPECT_NEAR(made.requests[0], 4 * made.requests[1], 1e-12);
    EXPECT_NEAR(made.requests[0], static_cast<double>(plan.lines[0].requests[0].bus_time.count()) / 1e8,
                1e-12);
    EXPECT_EQ(made.devices, made.requests) << "one request each";
    EXPECT_NEAR(sum(made.requests), plan.lines[0].utilization, 1e-6);
    EXPECT_FALSE(is_saturated(plan.lines[0]));
    EXPECT_EQ(busy(plan.lines[0]), plan.lines[0].utilization);
}

TEST(Shares, ARequestWithoutPeriodTakesAllTheTimeThatIsLeft) {
    const auto project = two_devices(0ms);
    const Plan plan = make_plan(project);
    const auto made = shares(project.lines[0], plan.lines[0]);
    EXPECT_TRUE(is_saturated(plan.lines[0]));
    EXPECT_EQ(busy(plan.lines[0]), 1.0);
    EXPECT_LT(plan.lines[0].utilization, 0.5);
    EXPECT_GT(made.devices[1], 0.5);
    EXPECT_NEAR(sum(made.devices), 1.0, 1e-6);
}

TEST(Shares, RequestsWithoutPeriodDivideTheRestByTheirBusTimes) {
    const auto plan = plan_of({}, {int16(0).read(3).every(0ms), int32(100).read(3).every(0ms)});
    const auto made = shares(project({}, {}).lines[0], plan);
    ASSERT_EQ(made.requests.size(), 2U);
    EXPECT_NEAR(made.requests[1] / made.requests[0],
                static_cast<double>(plan.requests[1].bus_time.count()) /
                    static_cast<double>(plan.requests[0].bus_time.count()),
                1e-9);
    EXPECT_NEAR(sum(made.requests), 1.0, 1e-9);
}

TEST(Shares, AnOverloadedLineIsBusierThanASaturatedOne) {
    auto project = two_devices(0ms);
    project.lines[0].devices[0].variables[0].period = 1ms;
    const Plan plan = make_plan(project);
    EXPECT_GT(busy(plan.lines[0]), 1.0);
    EXPECT_EQ(shares(project.lines[0], plan.lines[0]).devices[1], 0.0) << "nothing is left";
}

TEST(Shares, WritesByCommandTakeNone) {
    const auto plan = plan_of({}, {int16(0).write(6).on_change()});
    const auto made = shares(project({}, {}).lines[0], plan);
    ASSERT_EQ(made.requests.size(), 1U);
    EXPECT_EQ(made.requests[0], 0.0);
    EXPECT_TRUE(largest_shares(plan, 8).empty());
}

TEST(Shares, TheLargestStreamsComeFirst) {
    const Plan plan = make_plan(two_devices(10ms));
    const auto all = largest_shares(plan.lines[0], 8);
    ASSERT_EQ(all.size(), 2U);
    EXPECT_EQ(all[0].device, 1U);
    EXPECT_EQ(all[0].variables, std::vector<std::size_t>{0});
    EXPECT_GT(all[0].share, all[1].share);
    EXPECT_EQ(largest_shares(plan.lines[0], 1).size(), 1U);
}

TEST(Shares, RequestsThatTakeTurnsAreOneStream) {
    const auto plan = plan_of({.strategy = model::Strategy::optimal},
                              {int16(0).read(3).every(100ms), int16(1).read(3).every(1s)});
    ASSERT_GT(plan.requests.size(), 1U);
    const auto all = largest_shares(plan, 8);
    ASSERT_EQ(all.size(), 1U);
    EXPECT_EQ(all[0].variables, (std::vector<std::size_t>{0, 1}));
    EXPECT_NEAR(all[0].share, plan.utilization, 1e-6);
}

}  // namespace shares_test
}  // namespace takt::plan
