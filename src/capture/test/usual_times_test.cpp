#include "takt/capture/usual_times.hpp"

#include <gtest/gtest.h>

namespace takt::capture {
namespace usual_times_test {

TEST(UsualTimes, AreTheSecondLongestOfTheLastEight) {
    UsualTimes times;
    EXPECT_EQ(times.of(1), std::nullopt);
    times.add(1, 900);
    EXPECT_EQ(times.of(1), 900);
    for (const int time : {5, 7, 6}) times.add(1, time);
    EXPECT_EQ(times.of(1), 7) << "one slow response does not count";
    times.add(1, 800);
    EXPECT_EQ(times.of(1), 800) << "the second one does";
    for (int i = 0; i < 7; ++i) times.add(1, 5);
    EXPECT_EQ(times.of(1), 5) << "as long as it is one of the last eight";
    EXPECT_EQ(times.of(2), std::nullopt);
}

}  // namespace usual_times_test
}  // namespace takt::capture
