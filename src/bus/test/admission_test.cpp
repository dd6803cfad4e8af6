#include "takt/bus/admission.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <vector>

namespace takt::bus {
namespace {

using namespace std::chrono_literals;

constexpr Instant at(Duration since_start) {
    return Instant{} + since_start;
}

TEST(Admission, CountsTheIntervalFromTheEnd) {
    Admission admission(1, 1s);
    EXPECT_TRUE(admission.admits(at(0s)));
    admission.started(at(0s));
    EXPECT_FALSE(admission.admits(at(2s)));
    EXPECT_EQ(admission.next_admission(at(2s)), kNever) << "it must end first";
    admission.ended(at(3s));
    EXPECT_EQ(admission.next_admission(at(3s)), at(4s));
    EXPECT_FALSE(admission.admits(at(4s) - 1ns));
    EXPECT_TRUE(admission.admits(at(4s)));
}

TEST(Admission, ATransactionWithoutATokenEmptiesTheBucket) {
    Admission admission(1, 1s);
    admission.started(at(0s));
    admission.ended(at(0s));
    admission.started(at(900ms));  // the line was free
    admission.ended(at(1000ms));
    EXPECT_EQ(admission.next_admission(at(1000ms)), at(2000ms));
}

TEST(Admission, ABurstGoesAtOnce) {
    Admission admission(3, 100ms);
    for (const Duration start : {0ms, 10ms, 20ms}) {
        EXPECT_TRUE(admission.admits(at(start)));
        admission.started(at(start));
        admission.ended(at(start + 10ms));
    }
    EXPECT_EQ(admission.next_admission(at(30ms)), at(130ms));
    admission.started(at(10s));
    admission.ended(at(10s));
    EXPECT_TRUE(admission.admits(at(10s))) << "never more than three are saved";
    admission.started(at(10s));
    admission.ended(at(10s));
    admission.started(at(10s));
    admission.ended(at(10s));
    EXPECT_EQ(admission.next_admission(at(10s)), at(10s) + 100ms);
}

TEST(Admission, SeveralInFlightStopTheClockOnce) {
    Admission admission(2, 100ms);
    admission.started(at(0ms));
    EXPECT_TRUE(admission.admits(at(10ms))) << "the second of the burst";
    admission.started(at(10ms));
    admission.ended(at(50ms));
    EXPECT_EQ(admission.next_admission(at(50ms)), kNever);
    admission.ended(at(70ms));
    EXPECT_EQ(admission.next_admission(at(70ms)), at(170ms));
}

TEST(Admission, ARepetitionTakesNoTokenAndStopsTheClock) {
    Admission admission(1, 100ms);
    admission.started(at(0ms));
    admission.ended(at(10ms));
    admission.resumed(at(60ms));
    admission.ended(at(80ms));
    EXPECT_EQ(admission.next_admission(at(80ms)), at(130ms));
}

TEST(Admission, TheEndMayLieInTheFuture) {
    Admission admission(1, 100ms);
    admission.started(at(0ms));
    admission.ended(at(40ms));
    EXPECT_EQ(admission.next_admission(at(30ms)), at(140ms));
}

TEST(Admission, WithoutAnIntervalItAdmitsAlways) {
    Admission admission(1, 0ms);
    admission.started(at(5ms));
    EXPECT_TRUE(admission.admits(at(6ms)));
    admission.ended(at(7ms));
    EXPECT_TRUE(admission.admits(at(7ms)));
}

TEST(Admission, AProductBeyondAnInstantIsCut) {
    Admission admission(1'000'000, 24h);
    for (int i = 0; i < 100; ++i) {
        EXPECT_TRUE(admission.admits(at(1s * i)));
        admission.started(at(1s * i));
        admission.ended(at(1s * i));
    }
}

// From the first start to the n-th of those admitted, others have at least (n - burst) intervals of the line.
RC_GTEST_PROP(Admission, LeavesTheLineToOthers, ()) {
    const auto burst = *rc::gen::inRange<std::uint32_t>(1, 5);
    constexpr Duration kInterval = 10ms;
    Admission admission(burst, kInterval);
    Instant now = at(0ms);
    std::vector<Duration> taken;  // line time before each admitted start
    std::vector<Instant> starts;
    Duration total{};
    for (const int length : *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 60))) {
        now += *rc::gen::inRange(0, 40) * 1ms;
        if (*rc::gen::inRange(0, 3) > 0) now = std::max(now, admission.next_admission(now));
        if (admission.admits(now)) {
            starts.push_back(now);
            taken.push_back(total);
        }
        admission.started(now);
        now += length * 1ms;
        total += length * 1ms;
        admission.ended(now);
        for (std::size_t first = 0; first < starts.size(); ++first) {
            const std::size_t last = starts.size() - 1;
            const Duration left = starts[last] - starts[first] - (taken[last] - taken[first]);
            const auto beyond =
                static_cast<std::int64_t>(last - first) - static_cast<std::int64_t>(burst) + 1;
            if (beyond > 0) RC_ASSERT(left >= kInterval * beyond);
        }
    }
}

}  // namespace
}  // namespace takt::bus
