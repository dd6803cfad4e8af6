#include "devices/load_meter.hpp"

#include <gtest/gtest.h>

namespace takt::poll::test {
namespace load_meter_test {

using namespace std::chrono_literals;

constexpr Instant kStart{1000s};

TEST(LoadMeter, FollowsTheLastSeconds) {
    LoadMeter meter;
    meter.start(kStart);
    EXPECT_EQ(meter.at(kStart), 0);
    for (auto t = 1s; t <= 20s; t += 1s) meter.add(kStart + t, 200ms);
    EXPECT_NEAR(meter.at(kStart + 20s), 0.2, 0.04);
    for (auto t = 21s; t <= 30s; t += 1s) meter.add(kStart + t, 900ms);
    EXPECT_NEAR(meter.at(kStart + 30s), 0.9, 0.1) << "ten seconds later nothing is left of the past";
}

TEST(LoadMeter, AnIdleLineHasNone) {
    LoadMeter meter;
    meter.start(kStart);
    meter.add(kStart + 1s, 500ms);
    EXPECT_EQ(meter.at(kStart + 1s), 0.5);
    EXPECT_EQ(meter.at(kStart + 4s), 0.125);
    EXPECT_EQ(meter.at(kStart + 5s), 0.1) << "the window is over, and still counts";
    EXPECT_EQ(meter.at(kStart + 10s), 0);
    EXPECT_EQ(meter.at(kStart + 3600s), 0);
}

TEST(LoadMeter, ALongTransactionIsNotMoreThanEverything) {
    LoadMeter meter;
    meter.start(kStart);
    meter.add(kStart + 60s, 60s);
    EXPECT_EQ(meter.at(kStart + 60s), 1);
}

TEST(LoadMeter, BeginsAnewWithTheConnection) {
    LoadMeter meter;
    meter.start(kStart);
    meter.add(kStart + 2s, 2s);
    meter.start(kStart + 3s);
    EXPECT_EQ(meter.at(kStart + 4s), 0);
}

}  // namespace load_meter_test
}  // namespace takt::poll::test
