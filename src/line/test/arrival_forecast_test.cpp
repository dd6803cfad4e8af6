#include "loop/arrival_forecast.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace takt::line {
namespace arrival_forecast_test {

using namespace std::chrono_literals;
using Spans = std::vector<Duration>;

Spans repeated(const Spans& cycle, std::size_t count) {
    Spans all;
    for (std::size_t i = 0; i < count; ++i) all.push_back(cycle[i % cycle.size()]);
    return all;
}

/// From the last of the arrivals, which are that far apart, to the next; kNever: none is expected.
Duration until_next(const Spans& apart) {
    ArrivalForecast forecast(50us);
    Instant t{1h};
    forecast.on_arrival(t);
    for (const Duration span : apart) forecast.on_arrival(t += span);
    return forecast.next() == kNever ? Duration::max() : forecast.next() - t;
}

TEST(ArrivalForecast, ExpectsTheNextOfASteadyCycle) {
    EXPECT_EQ(until_next(repeated({1ms}, 8)), 1ms);
    EXPECT_EQ(until_next(repeated({300us, 700us}, 20)), 300us);
    EXPECT_EQ(until_next(repeated({300us, 700us}, 21)), 700us);
    EXPECT_EQ(until_next(repeated({1ms, 1ms, 1ms, 1ms, 1ms, 1ms, 1ms, 13ms}, 31)), 13ms);
}

TEST(ArrivalForecast, ExpectsNothingWithoutACycle) {
    EXPECT_EQ(until_next({}), Duration::max());
    EXPECT_EQ(until_next(repeated({1ms}, 7)), Duration::max()) << "too few";
    EXPECT_EQ(until_next({1ms, 3ms, 2ms, 7ms, 4ms, 1ms, 9ms, 2ms, 5ms, 8ms, 1ms, 6ms, 3ms, 4ms, 7ms, 2ms}),
              Duration::max());
}

TEST(ArrivalForecast, ToleratesJitterAndALateArrival) {
    EXPECT_EQ(until_next({1ms, 1030us, 980us, 1ms, 960us, 1040us, 1ms, 1ms}), 1ms);
    EXPECT_EQ(until_next({1ms, 1ms, 1ms, 1400us, 600us, 1ms, 1ms, 1ms}), 1ms);
    EXPECT_EQ(until_next({1ms, 1200us, 800us, 1400us, 600us, 1ms, 1ms, 1ms}), Duration::max());
}

TEST(ArrivalForecast, AnExpectationThatHasPassedStays) {
    ArrivalForecast forecast(50us);
    for (int i = 0; i <= 8; ++i) forecast.on_arrival(Instant{i * 1ms});
    EXPECT_EQ(forecast.next(), Instant{9ms});
    forecast.on_arrival(Instant{9ms + 10ms});
    EXPECT_EQ(forecast.next(), Instant{20ms}) << "one arrival may be missing";
}

}  // namespace arrival_forecast_test
}  // namespace takt::line
