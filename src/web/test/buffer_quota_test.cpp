#include "http/buffer_quota.hpp"

#include <gtest/gtest.h>

namespace takt::web {
namespace buffer_quota_test {

using enum BufferQuota::Verdict;

TEST(BufferQuota, TheExcessOfAVisitorIsItsOwn) {
    BufferQuota quota(100, 250);
    EXPECT_EQ(quota.change("a", 100), admitted);
    EXPECT_EQ(quota.change("a", 1), visitor_full);
    EXPECT_EQ(quota.change("a", 10'000), visitor_full);
    EXPECT_EQ(quota.held(), 100u);
    EXPECT_EQ(quota.change("b", 100), admitted);
    EXPECT_EQ(quota.change("c", 50), admitted);
    EXPECT_EQ(quota.change("c", 1), full);
    EXPECT_EQ(quota.change("a", -10'101), admitted);
    EXPECT_EQ(quota.held(), 151u);
}

TEST(BufferQuota, GivesEverythingBack) {
    BufferQuota quota(100, 250);
    static_cast<void>(quota.change("a", 300));
    static_cast<void>(quota.change("b", 20));
    static_cast<void>(quota.change("a", -300));
    static_cast<void>(quota.change("b", -20));
    EXPECT_EQ(quota.held(), 0u);
}

}  // namespace buffer_quota_test
}  // namespace takt::web
