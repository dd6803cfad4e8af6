#include "devices/link_watch.hpp"

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

TEST(LinkWatch, AClosedConnectionIsOpenedWhenItIsNeeded) {
    LinkWatch link;
    EXPECT_FALSE(link.opens_at()) << "the driver knows when";
    link.up(at(1s));
    link.request_ended(at(2s), true);
    link.closed(at(3s), false);
    EXPECT_TRUE(link.usable());
    EXPECT_EQ(link.up_since(), at(1s)) << "no outage";
    EXPECT_EQ(link.opens_at(), kNever);
    link.need(true);
    EXPECT_EQ(link.opens_at(), at(3s));
    link.up(at(4s));
    EXPECT_EQ(link.up_since(), at(1s));
    link.lost();
    EXPECT_FALSE(link.usable());
    EXPECT_FALSE(link.opens_at());
}

TEST(LinkWatch, ConnectionsOfNoUseAreMadeMoreAndMoreSeldom) {
    LinkWatch link;
    Instant now = at(0s);
    for (const auto pause : {250ms, 500ms, 1000ms, 2000ms, 4000ms, 5000ms, 5000ms}) {
        link.up(now);
        link.received(now);
        link.closed(now, false);
        link.need(true);
        EXPECT_EQ(link.opens_at(), now + pause) << "a byte is no response";
        now += 10s;
    }
    link.up(now);
    link.request_ended(now, true);
    link.closed(now, false);
    link.up(now);
    link.closed(now, false);
    link.need(true);
    EXPECT_EQ(link.opens_at(), now + 250ms);
}

TEST(LinkWatch, APeerThatClosesAfterEachResponseIsAskedOnceAConnection) {
    LinkWatch link;
    for (int i = 0; i < 2; ++i) {
        EXPECT_FALSE(link.one_request());
        link.up(at(1s));
        link.request_ended(at(1s), true);
        link.closed(at(1s), false);
    }
    EXPECT_TRUE(link.one_request());
    link.up(at(2s));
    EXPECT_FALSE(link.ends_after_request());
    link.request_ended(at(2s), true);
    EXPECT_TRUE(link.ends_after_request());
    link.lost();
    EXPECT_FALSE(link.one_request());
}

TEST(LinkWatch, AnIdlePeerThatClosesIsNotTakenForIt) {
    LinkWatch link;
    for (int i = 0; i < 3; ++i) {
        link.up(at(1s));
        link.request_ended(at(1s), true);
        link.closed(at(3s), false);
        link.up(at(4s));
        link.request_ended(at(4s), true);
        link.closed(at(4s), true);
    }
    EXPECT_FALSE(link.one_request());
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
