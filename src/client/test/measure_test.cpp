#include "takt/client/measure.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "takt/client/background_load.hpp"

namespace takt::client {
namespace measure_test {

using namespace std::chrono_literals;

TEST(Measure, EverySubjectHasSamples) {
    for (const auto subject : kSubjects) {
        SCOPED_TRACE(static_cast<int>(subject));
        const auto measured = measure(subject, {.time = 200ms});
        ASSERT_TRUE(measured);
        EXPECT_GT(measured->count(), 5U);
        EXPECT_LE(measured->count(), 200U) << "at most one in a millisecond";
        EXPECT_GT(measured->max(), Duration::zero());
    }
}

TEST(Measure, CallsBackOnItsThreads) {
    std::thread::id measuring;
    std::thread::id echoing;
    int progress = 0;
    const auto measured = measure(
        Subject::loopback, {.time = 250ms,
                            .begin_thread = [&](line::Loop&) { measuring = std::this_thread::get_id(); },
                            .begin_peer = [&] { echoing = std::this_thread::get_id(); },
                            .progress = [&](Duration) { ++progress; }});
    ASSERT_TRUE(measured);
    EXPECT_NE(measuring, std::thread::id());
    EXPECT_NE(measuring, std::this_thread::get_id());
    EXPECT_NE(echoing, std::thread::id());
    EXPECT_NE(echoing, measuring);
    EXPECT_GE(progress, 1);
}

TEST(Measure, EndsEarlyWhenItIsStopped) {
    const std::atomic<bool> stop = true;
    const auto before = std::chrono::steady_clock::now();
    ASSERT_TRUE(measure(Subject::pty, {.time = 60s, .stop = &stop}));
    EXPECT_LT(std::chrono::steady_clock::now() - before, 30s);
}

TEST(Measure, WorksUnderLoad) {
    const BackgroundLoad load(2);
    const auto measured = measure(Subject::wake_up, {.time = 200ms});
    ASSERT_TRUE(measured);
    EXPECT_GT(measured->count(), 0U);
}

TEST(Budget, IsTheGreatestSampleRoundedUp) {
    LatencyStatistics wake_up;
    LatencyStatistics loopback;
    LatencyStatistics pty;
    wake_up.record(20us);
    wake_up.record(101us);
    loopback.record(300us);
    pty.record(80us);
    EXPECT_EQ(budget_of(wake_up, loopback, pty).jitter, 200us);
    EXPECT_EQ(budget_of(wake_up, loopback, pty).overhead, 300us);
    EXPECT_EQ(budget_of(wake_up, pty, {}).overhead, 100us);
    EXPECT_EQ(budget_of({}, {}, {}).jitter, 0us);
}

}  // namespace measure_test
}  // namespace takt::client
