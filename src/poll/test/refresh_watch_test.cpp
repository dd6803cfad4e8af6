#include "reads/refresh_watch.hpp"

#include <gtest/gtest.h>

namespace takt::poll {
namespace refresh_watch_test {

using namespace std::chrono_literals;

constexpr Instant at(Duration t) {
    return Instant(t);
}

const std::optional kBound = plan::RefreshBound{.age = 120ms, .with_failures = 500ms};

TEST(RefreshWatch, AReadIsLateAfterItsBoundOnly) {
    RefreshWatch watch;
    watch.set_requests(2);
    EXPECT_FALSE(watch.answered(at(1s), at(1010ms), 0, kBound)) << "the first one";
    EXPECT_FALSE(watch.answered(at(1100ms), at(1120ms), 0, kBound)) << "as long as its bound";
    EXPECT_TRUE(watch.answered(at(1200ms), at(1221ms), 0, kBound));
    EXPECT_FALSE(watch.answered(at(5s), at(6s), 1, kBound)) << "another request";
    watch.forget(0);
    EXPECT_FALSE(watch.answered(at(9s), at(9001ms), 0, kBound));
    EXPECT_FALSE(watch.answered(at(99s), at(100s), 0, std::nullopt)) << "no bound";
}

TEST(RefreshWatch, AfterAFailureTheBoundWithFailuresHolds) {
    RefreshWatch watch;
    watch.set_requests(1);
    EXPECT_FALSE(watch.answered(at(1s), at(1010ms), 0, kBound));
    watch.failed(at(1100ms));
    EXPECT_FALSE(watch.answered(at(1200ms), at(1400ms), 0, kBound));
    EXPECT_FALSE(watch.answered(at(1600ms), at(1650ms), 0, kBound))
        << "began within 500 ms after the failure";
    EXPECT_FALSE(watch.answered(at(1700ms), at(1710ms), 0, kBound)) << "in time";
    EXPECT_TRUE(watch.answered(at(1850ms), at(1860ms), 0, kBound));
}

}  // namespace refresh_watch_test
}  // namespace takt::poll
