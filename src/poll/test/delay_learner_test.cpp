#include "devices/delay_learner.hpp"

#include <gtest/gtest.h>

namespace takt::poll {
namespace delay_learner_test {

using namespace std::chrono_literals;
using Setting = DelayFinding::Setting;

model::Device device_of(bool learns, std::optional<Duration> turnaround = {}) {
    model::Device device;
    device.response_timeout = 500ms;
    device.turnaround = turnaround;
    device.learn_turnaround = learns;
    return device;
}

TEST(DelayLearner, GivesTheLongestAndTheSharePerMille) {
    const auto device = device_of(false);
    DelayLearner learner(device, 500ms, false);
    for (int i = 0; i < 999; ++i) {
        learner.on_attempt();
        EXPECT_FALSE(learner.on_response(4ms, 2ms));
    }
    learner.on_attempt();
    EXPECT_FALSE(learner.on_response(40ms, 2ms));
    const auto measured = learner.measured();
    EXPECT_EQ(measured.exchanges, 1000U);
    EXPECT_EQ(measured.attempts, 1000U);
    EXPECT_EQ(measured.longest, 40ms);
    EXPECT_GE(measured.p999, 4ms);
    EXPECT_LE(measured.p999, 4500us);
    EXPECT_EQ(learner.wait(), 500ms);
    EXPECT_FALSE(learner.take_news()) << "the device does not learn its turnaround";
}

TEST(DelayLearner, ADelayBelowZeroCountsAsZero) {
    const auto device = device_of(false);
    DelayLearner learner(device, 500ms, false);
    (void)learner.on_response(-3ms, 2ms);
    EXPECT_EQ(learner.measured().exchanges, 1U);
    EXPECT_EQ(learner.measured().longest, 0ms);
}

TEST(DelayLearner, ContinuesWhatWasKept) {
    auto device = device_of(true);
    DelayLearner first(device, 500ms, true);
    for (int i = 0; i < 120; ++i) (void)first.on_response(i < 100 ? 3ms : 7300us, 2ms);
    (void)first.on_late(600ms, 500ms);
    device.times = first.learnt();
    EXPECT_EQ(device.measured_turnaround(), 600ms);
    const DelayLearner second(device, device.wait(true), true);
    EXPECT_EQ(second.measured(), first.measured());
    EXPECT_EQ(second.learnt(), first.learnt());
    EXPECT_EQ(second.lateness(), 600ms);
    EXPECT_EQ(second.wait(), 1200ms);
}

TEST(DelayLearner, TheTimeoutIsAtLeastTwiceTheLongestSeenAndNeverShrinks) {
    const auto device = device_of(true);
    DelayLearner learner(device, 20ms, true);
    (void)learner.on_response(9ms, 2ms);
    EXPECT_EQ(learner.wait(), 20ms);
    (void)learner.on_response(15ms, 2ms);
    EXPECT_EQ(learner.wait(), 30ms);
    (void)learner.on_response(1ms, 2ms);
    EXPECT_EQ(learner.wait(), 30ms);
    const auto found = learner.on_late(80ms, 30ms);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->setting, Setting::learnt_timeout);
    EXPECT_EQ(found->limit, 30ms);
    EXPECT_EQ(found->advised, 160ms);
    EXPECT_EQ(learner.wait(), 160ms);
    EXPECT_FALSE(learner.on_late(60ms, 30ms)) << "of a request that was sent before";
    EXPECT_EQ(learner.wait(), 160ms);
    (void)learner.on_late(1h, 160ms);
    EXPECT_EQ(learner.wait(), 65535ms);
}

TEST(DelayLearner, AWrittenTimeoutStays) {
    const auto device = device_of(true);
    DelayLearner learner(device, 500ms, false);
    const auto found = learner.on_late(700ms, 500ms);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->setting, Setting::response_timeout);
    EXPECT_EQ(found->advised, 0ms) << "a single pause";
    EXPECT_EQ(learner.wait(), 500ms);
}

TEST(DelayLearner, TheAdviceFollowsFromTheThirdLongestLateResponse) {
    auto device = device_of(false);
    DelayLearner learner(device, 500ms, false);
    (void)learner.on_late(9s, 500ms);
    EXPECT_FALSE(learner.on_late(600ms, 500ms));
    const auto found = learner.on_late(700ms, 500ms);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->delay, 9s);
    EXPECT_EQ(found->advised, 800ms);
    EXPECT_EQ(found->count, 3U);
    EXPECT_EQ(found->later, 1U);
    EXPECT_FALSE(learner.on_late(610ms, 500ms)) << "the advice does not grow";
    EXPECT_EQ(learner.finding()->count, 4U);
    EXPECT_EQ(learner.on_late(8s, 500ms)->advised, 1000ms);

    device.times = learner.learnt();
    const DelayLearner next(device, 500ms, false);
    EXPECT_EQ(next.finding(), learner.finding()) << "in the next run, too";
    device.response_timeout = 1000ms;
    EXPECT_FALSE(DelayLearner(device, 1000ms, false).finding()) << "two pauses are left";
}

TEST(DelayLearner, APauseDoesNotRaiseTheAdvisedTurnaround) {
    const auto device = device_of(false, 20ms);
    DelayLearner learner(device, 500ms, false);
    for (int i = 0; i < 2; ++i) EXPECT_FALSE(learner.on_response(60ms, 20ms));
    EXPECT_EQ(learner.on_response(60ms, 20ms)->advised, 80ms);
    EXPECT_FALSE(learner.on_response(400ms, 20ms));
    EXPECT_EQ(learner.finding()->delay, 400ms);
    EXPECT_EQ(learner.finding()->advised, 80ms);
    EXPECT_EQ(learner.finding()->later, 1U);
}

TEST(DelayLearner, NewsAreALateResponseAndALongerOneOfADeviceThatLearns) {
    const auto device = device_of(true);
    DelayLearner learner(device, 500ms, true);
    (void)learner.on_response(5ms, 2ms);
    EXPECT_TRUE(learner.take_news());
    EXPECT_FALSE(learner.take_news());
    (void)learner.on_response(5ms, 2ms);
    EXPECT_FALSE(learner.take_news());
    (void)learner.on_response(6ms, 2ms);
    EXPECT_TRUE(learner.take_news());
    (void)learner.on_late(3ms, 5ms);
    EXPECT_TRUE(learner.take_news());
}

TEST(DelayLearner, AProjectReadAgainContinues) {
    const auto device = device_of(true);
    DelayLearner old(device, 20ms, true);
    (void)old.on_response(30ms, 2ms);
    (void)old.on_late(90ms, 60ms);
    DelayLearner learner(device, 500ms, true);
    learner.take_over(old, true);
    EXPECT_EQ(learner.measured(), old.measured());
    EXPECT_EQ(learner.wait(), 500ms);
    EXPECT_EQ(learner.finding(), old.finding());
    learner.take_over(old, false);
    EXPECT_FALSE(learner.finding());
}

}  // namespace delay_learner_test
}  // namespace takt::poll
