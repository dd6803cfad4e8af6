#include "takt/bus/release.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace takt::bus {
namespace release_test {

using namespace std::chrono_literals;

constexpr Instant at(Duration since_start) {
    return Instant{} + since_start;
}

TEST(PeriodicRelease, StaysOnTheGridAndSkipsWithoutBurst) {
    PeriodicRelease release(100ms);
    release.restart(at(5ms));
    struct Step {
        Duration served, next;
        std::uint64_t skipped;
    };
    constexpr Step kSteps[] = {
        {5ms, 105ms, 0},   {110ms, 205ms, 0}, {205ms, 305ms, 0},
        {390ms, 405ms, 0}, {640ms, 705ms, 2},  // 505 and 605 passed meanwhile
        {705ms, 805ms, 0},
    };
    for (const auto& step : kSteps) {
        EXPECT_EQ(release.serve(at(step.served)), step.skipped);
        EXPECT_EQ(release.next(), at(step.next));
    }
}

TEST(PeriodicRelease, WithoutAPeriodItIsAlwaysReleased) {
    PeriodicRelease release(0ms);
    release.restart(at(5ms));
    EXPECT_EQ(release.serve(at(7ms)), 0U);
    EXPECT_EQ(release.next(), at(7ms));
}

RC_GTEST_PROP(PeriodicRelease, ServesAndSkipsMakeUpTheGrid, ()) {
    PeriodicRelease release(10ms);
    release.restart(at(0ms));
    Instant now = at(0ms);
    std::int64_t releases = 0;
    for (const int late : *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 50))) {
        now = std::max(now, release.next()) + late * 1ms;
        releases += 1 + static_cast<std::int64_t>(release.serve(now));
        RC_ASSERT(release.next() > now);
        RC_ASSERT(release.next() - now <= 10ms);
        RC_ASSERT(release.next() == at(releases * 10ms));
    }
}

TEST(PeriodicRelease, ComesBackToItsGrid) {
    struct Case {
        Duration since, next;
    };
    constexpr Case kCases[] = {{0ms, 30ms},    {30ms, 30ms},   {31ms, 130ms},
                               {130ms, 130ms}, {429ms, 430ms}, {100'031ms, 100'130ms}};
    for (const auto& [since, next] : kCases) {
        PeriodicRelease release(100ms);
        release.follow(at(30ms), at(since));
        EXPECT_EQ(release.next(), at(next));
        EXPECT_EQ(release.serve(release.next()), 0U);
        EXPECT_EQ(release.last(), at(next));
        EXPECT_EQ(release.next(), at(next + 100ms));
    }
}

TEST(PeriodicRelease, OneMoreBetweenTheInstantsMovesNothing) {
    PeriodicRelease release(100ms);
    release.follow(at(30ms), at(150ms));
    release.release_at(at(150ms));
    EXPECT_EQ(release.next(), at(150ms));
    EXPECT_EQ(release.serve(at(160ms)), 0U);
    EXPECT_EQ(release.last(), at(130ms));
    EXPECT_EQ(release.next(), at(230ms));
    release.follow(at(30ms), at(250ms));
    release.release_at(at(250ms));
    EXPECT_EQ(release.serve(at(335ms)), 1U);
    EXPECT_EQ(release.next(), at(430ms));
}

TEST(PeriodMeter, ReportsAnOverrunOnceAndItsEnd) {
    PeriodMeter meter(100ms);
    Instant now = at(0ms);
    int changes = 0;
    const auto run = [&](int count, Duration period) {
        for (int i = 0; i < count; ++i) changes += meter.started(now += period) ? 1 : 0;
    };
    run(20, 100ms);
    EXPECT_EQ(meter.pace(), 100ms);
    run(1, 170ms);  // a single slip is none
    run(10, 103ms);
    EXPECT_EQ(changes, 0);
    run(10, 130ms);
    EXPECT_EQ(changes, 1);
    EXPECT_TRUE(meter.overrun());
    run(100, 100ms);
    EXPECT_EQ(changes, 1) << "not yet for 10 s";
    run(20, 100ms);
    EXPECT_EQ(changes, 2);
    EXPECT_FALSE(meter.overrun());
    meter.interrupt();
    run(1, 10s);
    EXPECT_EQ(changes, 2) << "the interruption is no overrun";
}

TEST(PeriodMeter, AnOverrunEndsWhenPeriodsHoldAgainThoughOneIsLateNowAndThen) {
    PeriodMeter meter(100ms);
    Instant now = at(0ms);
    const auto run = [&](int count, Duration period) {
        for (int i = 0; i < count; ++i) meter.started(now += period);
    };
    run(10, 900ms);
    ASSERT_TRUE(meter.overrun());
    for (int i = 0; i < 16; ++i) {
        run(7, 100ms);
        run(1, 110ms);
    }
    EXPECT_FALSE(meter.overrun());
    EXPECT_LT(meter.pace(), 105ms) << "what was before does not count any more";
}

TEST(PeriodMeter, ALatePeriodNowAndThenIsNotLateWhileTheMeanIsKept) {
    PeriodMeter meter(100ms);
    Instant now = at(0ms);
    for (int i = 0; i < 10; ++i) meter.started(now += 130ms);
    EXPECT_TRUE(meter.is_late());
    for (int i = 0; i < 40; ++i) meter.started(now += i % 4 == 0 ? 107ms : 99ms);
    EXPECT_TRUE(meter.overrun()) << "not yet for 10 s";
    EXPECT_FALSE(meter.is_late());
}

// Every second something else is more urgent, for three periods.
TEST(PeriodMeter, ALineNearItsLimitDoesNotChangeTheStateWithEveryRound) {
    PeriodMeter meter(100ms);
    Instant now = at(0ms);
    int changes = 0;
    const auto run = [&](int count, Duration period) {
        for (int i = 0; i < count; ++i) changes += meter.started(now += period) ? 1 : 0;
    };
    for (int i = 0; i < 60; ++i) {
        run(3, 150ms);
        run(7, 98ms);
    }
    EXPECT_EQ(changes, 1);
    EXPECT_TRUE(meter.overrun());
}

TEST(PeriodMeter, TheEndOfAnOverrunTakesTenPeriodsAndAnInterruptionDoesNotCount) {
    PeriodMeter meter(10s);
    Instant now = at(0ms);
    const auto run = [&](int count, Duration period) {
        for (int i = 0; i < count; ++i) meter.started(now += period);
    };
    run(1, 0s);
    run(8, 20s);
    ASSERT_TRUE(meter.overrun());
    run(15, 10s);
    EXPECT_TRUE(meter.overrun()) << "until the sixth, two of the last eight are too long";
    run(1, 10s);
    EXPECT_FALSE(meter.overrun());
    run(8, 20s);
    ASSERT_TRUE(meter.overrun());
    meter.interrupt();
    run(1, 1h);
    run(9, 10s);
    EXPECT_TRUE(meter.overrun());
}

TEST(PeriodMeter, AsFastAsTheLineAllowsIsNeverTooSlow) {
    PeriodMeter meter(0ms);
    for (int i = 0; i < 20; ++i) EXPECT_FALSE(meter.started(at(i * 1s)));
    EXPECT_EQ(meter.pace(), 1s);
}

TEST(PeriodMeter, TheRealPeriodIsTheTimeBetweenAnsweredReads) {
    PeriodMeter meter(100ms);
    const auto read = [&](Duration t, bool answered) {
        meter.started(at(t));
        if (answered) meter.answered(at(t));
    };
    EXPECT_EQ(meter.real().count(), 0U);
    read(0ms, true);
    EXPECT_EQ(meter.real().count(), 0U) << "one answer is no period";
    read(100ms, false);
    read(200ms, false);
    read(300ms, true);
    read(400ms, true);
    EXPECT_EQ(meter.real().count(), 2U);
    EXPECT_EQ(meter.real().max(), 300ms);
    EXPECT_EQ(meter.real().mean(), 200ms);
    EXPECT_EQ(meter.recent(), 300ms - 200ms / 8);
    meter.interrupt();  // an outage
    read(1400ms, true);
    EXPECT_EQ(meter.real().max(), 1s);
    meter.pause();
    read(9s, true);
    EXPECT_EQ(meter.real().max(), 1s) << "switched off on purpose";
    EXPECT_FALSE(meter.overrun());
}

TEST(PeriodMeter, AnIntervalOfMoreThanFourPeriodsIsAnOverrunWhileItLasts) {
    PeriodMeter meter(100ms);
    EXPECT_EQ(meter.overrun_due(), kNever) << "nothing is expected yet";
    EXPECT_FALSE(meter.started(at(0ms)));
    EXPECT_EQ(meter.overrun_due(), at(420ms) + 1ns);
    EXPECT_FALSE(meter.waiting(at(420ms)));
    EXPECT_TRUE(meter.waiting(at(420ms) + 1ns));
    EXPECT_TRUE(meter.overrun());
    EXPECT_GE(meter.pace(), 420ms);
    EXPECT_FALSE(meter.waiting(at(900ms))) << "it is reported once";
    EXPECT_TRUE(meter.is_late());
    EXPECT_FALSE(meter.started(at(1000ms)));
    EXPECT_TRUE(meter.overrun());
    EXPECT_TRUE(meter.is_late());
    EXPECT_FALSE(meter.started(at(1100ms)));
    EXPECT_TRUE(meter.overrun()) << "it ends when the period was kept for 10 s";
    EXPECT_FALSE(meter.is_late()) << "the status shows the present";
    for (Duration t = 1200ms; t < 10'500ms; t += 100ms) EXPECT_FALSE(meter.started(at(t)));
    EXPECT_TRUE(meter.started(at(10'500ms)));
    EXPECT_FALSE(meter.overrun());
    meter.interrupt();
    EXPECT_EQ(meter.overrun_due(), kNever);
    EXPECT_EQ(PeriodMeter(0ms).overrun_due(), kNever);
}

}  // namespace release_test
}  // namespace takt::bus
