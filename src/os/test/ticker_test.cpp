#include "takt/os/ticker.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

namespace takt::os {
namespace ticker_test {

TEST(Ticker, CallsAtOnceAgainAndALastTime) {
    std::atomic<int> turns = 0;
    std::atomic<int> last = 0;
    Ticker ticker("takt-test", std::chrono::milliseconds(1), [&](bool ending) {
        ++turns;
        if (ending) ++last;
    });
    while (turns < 3) std::this_thread::yield();
    EXPECT_EQ(last, 0);
    ticker.end();
    const int at_end = turns;
    EXPECT_EQ(last, 1);
    ticker.end();
    EXPECT_EQ(turns, at_end);
}

TEST(Ticker, DoesNotWaitForThePeriodAtTheEnd) {
    std::vector<bool> turns;
    {
        const Ticker ticker("takt-test", std::chrono::hours(1), [&](bool last) { turns.push_back(last); });
    }
    EXPECT_TRUE(turns.back());
    EXPECT_LE(turns.size(), 2U);
}

}  // namespace ticker_test
}  // namespace takt::os
