#include "../link_watch.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll::test {
namespace link_watch_test {

TEST(LinkWatch, KnowsWhetherThereIsAndWasALink) {
    LinkWatch link;
    EXPECT_FALSE(link.up_since());
    EXPECT_FALSE(link.was_up());
    link.up(at(5s));
    EXPECT_EQ(link.up_since(), at(5s));
    link.lost();
    EXPECT_FALSE(link.up_since());
    EXPECT_TRUE(link.was_up());
}

TEST(LinkWatch, ASilentConnectionIsGivenUpAfterHalfAMinute) {
    LinkWatch link;
    link.up(at(0s));
    link.check(at(29s));
    EXPECT_FALSE(link.given_up());
    link.check(at(30s));
    EXPECT_TRUE(link.given_up());
}

TEST(LinkWatch, EachConnectionMayBeSilentTwiceAsLong) {
    LinkWatch link;
    Duration allowed = 30s;
    Instant now = at(0s);
    for (int i = 0; i < 8; ++i, allowed = std::min<Duration>(2 * allowed, 10min)) {
        link.up(now);
        link.check(now + allowed - 1s);
        EXPECT_FALSE(link.given_up()) << i;
        link.check(now + allowed);
        EXPECT_TRUE(link.given_up()) << i;
        link.lost();
        EXPECT_FALSE(link.given_up());
        now += 1h;
    }
    link.up(now);
    link.received(now + 1s);
    link.check(now + 30s);
    EXPECT_FALSE(link.given_up()) << "counted from the last byte";
    link.check(now + 31s);
    EXPECT_TRUE(link.given_up()) << "a byte resets the back-off";
}

TEST(LinkWatch, AnotherPollerGoesOnWithTheSilence) {
    LinkWatch old;
    old.up(at(0s));
    old.check(at(30s));
    LinkWatch link;
    link.take_over(old);
    EXPECT_EQ(link.up_since(), at(0s));
    EXPECT_TRUE(link.was_up());
    EXPECT_FALSE(link.given_up());
    link.check(at(59s));
    EXPECT_FALSE(link.given_up());
    link.check(at(60s));
    EXPECT_TRUE(link.given_up());
}

}  // namespace link_watch_test
}  // namespace takt::poll::test
