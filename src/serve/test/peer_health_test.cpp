#include "takt/serve/peer_health.hpp"

#include <gtest/gtest.h>

namespace takt::serve {
namespace peer_health_test {

using namespace std::chrono_literals;

constexpr UnitId kUnit{9};
constexpr Instant kStart{1000s};

TEST(PeerHealth, CountsFailuresInARowOfEachPairOfUnitAndPeer) {
    PeerHealth health(3);
    for (int i = 0; i < 2; ++i) health.failed(kStart, kUnit, 1);
    EXPECT_TRUE(health.answering(kUnit, 1));
    health.answered(kUnit, 1);
    for (int i = 0; i < 3; ++i) health.failed(kStart, kUnit, 1);
    EXPECT_FALSE(health.answering(kUnit, 1));
    EXPECT_EQ(health.probe_at(kUnit, 1), kStart + 1s);
    EXPECT_TRUE(health.answering(kUnit, 2));
    EXPECT_TRUE(health.answering(UnitId{8}, 1));
    EXPECT_LE(health.probe_at(kUnit, 2), kStart);
    health.clear();
    EXPECT_TRUE(health.answering(kUnit, 1));
}

TEST(PeerHealth, AFullTableForgetsWhatMayAskAgainFirst) {
    PeerHealth health(1);
    for (std::uint64_t peer = 0; peer < PeerHealth::kMost; ++peer)
        health.failed(kStart + std::chrono::seconds(peer == 7 ? 0 : 100), kUnit, peer);
    health.failed(kStart + 100s, kUnit, PeerHealth::kMost);
    EXPECT_FALSE(health.answering(kUnit, PeerHealth::kMost));
    EXPECT_TRUE(health.answering(kUnit, 7));
    EXPECT_FALSE(health.answering(kUnit, 8));
}

}  // namespace peer_health_test
}  // namespace takt::serve
