// The time-out of an attempt, and how long it takes the line without a response.
#include "takt/wire/attempt_times.hpp"

#include <gtest/gtest.h>

#include "takt/base/time.hpp"

namespace takt::wire {
namespace attempt_times_test {

using namespace std::chrono_literals;

constexpr AttemptTimes<Duration> kAttempt{
    .request = 8ms, .wait = 100ms, .response = 9ms, .margin = 2ms, .silence = 4ms};

TEST(AttemptTimes, TimeOutCountsFromTheEndOfTheRequest) {
    EXPECT_EQ(kAttempt.time_out(), 111ms);
}

TEST(AttemptTimes, FailureEndsWhereTheNextRequestMayStart) {
    EXPECT_EQ(kAttempt.failure(), 123ms);
    EXPECT_EQ(kAttempt.failure(112ms), 124ms);
}

}  // namespace attempt_times_test
}  // namespace takt::wire
