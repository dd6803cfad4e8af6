#include "takt/bus/health.hpp"

#include <gtest/gtest.h>

namespace takt::bus {
namespace {

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

}  // namespace
}  // namespace takt::bus
