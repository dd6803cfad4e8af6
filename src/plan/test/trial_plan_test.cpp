// A trial plan is either the plan of the line, or left out because its proof could not hold.
#include "proof/trial_plan.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "builder.hpp"
#include "takt/plan/guarantee.hpp"

namespace takt::plan {
namespace trial_plan_test {

using namespace test;

bool same(const Request& a, const Request& b) {
    return a.device == b.device && a.variables == b.variables && a.read == b.read && a.start == b.start &&
           a.quantity == b.quantity && a.period == b.period && a.phase == b.phase && a.stream == b.stream &&
           a.deadline == b.deadline && a.bus_time == b.bus_time && a.why.code == b.why.code;
}

std::optional<LinePlan> trial_of(const model::Project& project) {
    std::size_t planned = 0;
    return trial_plan(project, 0, planned);
}

RC_GTEST_PROP(TrialPlan, IsThePlanUnlessItsProofCannotHold, ()) {
    const auto strategy =
        *rc::gen::element(model::Strategy::single, model::Strategy::classic, model::Strategy::optimal);
    const auto periods = *rc::gen::container<std::vector<Duration>>(
        20, rc::gen::element<Duration>(0ms, 20ms, 50ms, 80ms, 120ms, 1s, 1'234'567ns));
    std::vector<Item> items;
    for (std::size_t i = 0; i < periods.size(); ++i)
        items.push_back(int16(static_cast<int>(3 * i)).read(3).every(periods[i]));
    auto made = project({.strategy = strategy}, items);
    made.lines[0].devices.push_back(device(17, {.strategy = strategy}, items));
    made.lines[0].order = *rc::gen::element(model::PollOrder::deadline, model::PollOrder::address);
    for (auto& device : made.lines[0].devices)
        device.turnaround = std::chrono::microseconds(*rc::gen::inRange(0, 5000));

    const auto plan = plan_line(made, 0);
    const auto trial = trial_of(made);
    if (!trial) {
        RC_TAG("left out");
        const auto proved = guarantee_line(made, plan, Scope::without_failures);
        RC_ASSERT(!proved.feasible);
        RC_ASSERT(proved.utilization > 1);
    } else {
        RC_ASSERT(std::ranges::equal(trial->requests, plan.requests, same));
        RC_ASSERT(trial->cycle == plan.cycle);
        RC_ASSERT(trial->request_count == plan.request_count);
    }
}

TEST(TrialPlan, IsLeftOutWherePollingExceedsTheLine) {
    const auto items = row(30, int16(0).read(3).every(20ms));
    auto grouped = project({.registers_per_request = 30}, items);
    auto single = project({.strategy = model::Strategy::single}, items);
    for (auto* const made : {&grouped, &single}) made->lines[0].devices[0].turnaround = 2ms;
    EXPECT_TRUE(trial_of(grouped));
    EXPECT_FALSE(trial_of(single));
}

TEST(TrialPlan, CountsThePlannedVariables) {
    const auto items = row(30, int16(0).read(3).every(20ms));
    auto made = project({.strategy = model::Strategy::single}, items);
    made.lines[0].devices.push_back(device(17, {}, items));
    std::size_t planned = 5;
    EXPECT_FALSE(trial_plan(made, 0, planned));
    EXPECT_EQ(planned, 35U) << "the first device alone exceeds the line";
}

// The proof rounds such a period down; its result for several that alternate is not known beforehand.
TEST(TrialPlan, IsCompleteWithPeriodsOfPartsOfAMicrosecond) {
    const auto items = row(30, int16(0).read(3).every(1'000'500ns));
    EXPECT_TRUE(trial_of(project({.strategy = model::Strategy::single}, items)));
}

TEST(TrialPlan, DoesNotCountWritesAndTriggers) {
    const auto items = row(30, int16(0).write(0x10).on_change());
    EXPECT_TRUE(trial_of(project({.strategy = model::Strategy::single}, items)));
}

}  // namespace trial_plan_test
}  // namespace takt::plan
