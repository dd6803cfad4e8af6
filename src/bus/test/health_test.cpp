#include "takt/bus/health.hpp"

#include <gtest/gtest.h>

namespace takt::bus {
namespace health_test {

using namespace std::chrono_literals;

constexpr Instant at(Duration since_start) {
    return Instant{} + since_start;
}

TEST(Health, CountsFailuresInARow) {
    Health health(3);
    EXPECT_FALSE(health.failed(at(1s)));
    EXPECT_FALSE(health.failed(at(2s)));
    EXPECT_FALSE(health.answered());
    EXPECT_FALSE(health.failed(at(3s)));
    EXPECT_FALSE(health.failed(at(4s)));
    EXPECT_TRUE(health.answering());
    EXPECT_TRUE(health.failed(at(5s)));
    EXPECT_FALSE(health.answering());
    EXPECT_EQ(health.probe_at(), at(6s));
}

TEST(Health, ProbesDoubleUpToAMinuteAndBeginAnewAfterAnAnswer) {
    Health health(1);
    EXPECT_TRUE(health.failed(at(0s)));
    for (const Duration wait : {2s, 4s, 8s, 16s, 32s, 60s, 60s}) {
        const Instant probe = health.probe_at();
        EXPECT_FALSE(health.failed(probe));  // it did not answer before
        EXPECT_EQ(health.probe_at() - probe, wait);
        EXPECT_EQ(health.probe_wait(), wait);
    }
    EXPECT_TRUE(health.answered());
    EXPECT_TRUE(health.failed(at(1h)));
    EXPECT_EQ(health.probe_at(), at(1h + 1s));
}

TEST(Health, ProbesEarlyOncePerPeriodWhileTheBackOffIsLonger) {
    Health health(1);
    health.failed(at(0s));
    health.failed(at(1s));  // the next probe is due after 2 s
    EXPECT_EQ(health.early_probe_at(at(1s), 500ms), at(1500ms));
    EXPECT_EQ(health.early_probe_at(at(1s), 0s), at(2s));  // no period: the first back-off
    EXPECT_EQ(health.early_probe_at(at(1s), 2s), std::nullopt);
    EXPECT_TRUE(health.read_started(at(2800ms), 500ms));
    EXPECT_EQ(health.probe_at(), at(3300ms));
    EXPECT_FALSE(health.read_started(at(3300ms), 500ms));
    EXPECT_TRUE(health.answered());
    EXPECT_FALSE(health.read_started(at(0s), 500ms));
}

TEST(Health, ProbesAtOnceOnRequest) {
    Health health(1);
    EXPECT_FALSE(health.probe_now(at(0s)));
    health.failed(at(0s));
    health.failed(at(1s));
    EXPECT_TRUE(health.probe_now(at(1500ms)));
    EXPECT_EQ(health.probe_at(), at(1500ms));
    EXPECT_TRUE(health.probe_now(at(2s)));  // it waits for the line
    EXPECT_EQ(health.probe_at(), at(1500ms));
    EXPECT_FALSE(health.read_started(at(2s), 500ms));
    health.failed(at(3s));
    EXPECT_EQ(health.probe_at(), at(7s));  // the back-off grows as before
}

}  // namespace health_test
}  // namespace takt::bus
