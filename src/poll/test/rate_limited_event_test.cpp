// The admission of triggers, writes and changes.
#include "devices/rate_limited_event.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll::test {
namespace rate_limited_event_test {

TEST(RateLimitedEvent, WithoutABucketIsAdmittedWhenItArrives) {
    RateLimitedEvent event;
    event.arrive(at(0s), 7);
    EXPECT_TRUE(event.admitted);
    EXPECT_EQ(event.order, 7U);
}

TEST(RateLimitedEvent, WaitsForAToken) {
    RateLimitedEvent event(model::RateLimit{1s, 1});
    event.arrive(at(0s), 1);
    EXPECT_TRUE(event.admitted);
    event.arrive(at(100ms), 2);
    EXPECT_FALSE(event.admitted);
    EXPECT_FALSE(event.admit(at(999ms)));
    EXPECT_EQ(event.bucket->next_admission(at(999ms)), at(1s));
    EXPECT_TRUE(event.admit(at(1s)));
    EXPECT_TRUE(event.admit(at(1s))) << "it takes one token";
    EXPECT_EQ(event.bucket->next_admission(at(1s)), at(2s));
}

TEST(ArrivalCounter, NumbersArrivals) {
    ArrivalCounter arrivals;
    const auto first = arrivals.next();
    EXPECT_LT(first, arrivals.next());
}

}  // namespace rate_limited_event_test
}  // namespace takt::poll::test
