#include "takt/bus/unit_times.hpp"

#include <gtest/gtest.h>

namespace takt::bus {
namespace unit_times_test {

using namespace std::chrono_literals;

TEST(UnitTimes, TheLongestDelayGrowsAtOnceAndFallsSlowly) {
    UnitTimes times;
    times.on_response(10ms, true);
    times.on_response(26ms, true);
    EXPECT_EQ(times.longest_delay, 26ms);
    times.on_response(10ms, true);
    EXPECT_EQ(times.longest_delay, 25ms);
    for (int i = 0; i < 100; ++i) times.on_response(10ms, true);
    EXPECT_LT(times.longest_delay, 11ms);
}

TEST(UnitTimes, ResponsesThatMayBeEarlierOnesShortenNothing) {
    UnitTimes times;
    times.on_response(26ms, true);
    times.on_response(1ms, false);
    EXPECT_EQ(times.longest_delay, 26ms);
    times.on_response(46ms, false);
    EXPECT_EQ(times.longest_delay, 31ms) << "may be a late one";
    for (int i = 0; i < 20; ++i) times.on_response(46ms, false);
    EXPECT_GT(times.longest_delay, 45ms) << "the unit has become slower";
}

TEST(UnitTimes, ALateResponseLengthensTheWaitForOthers) {
    struct Case {
        Duration delay;
        Duration late_limit;
    };
    for (const auto& c : {Case{0ms, 100ms}, Case{120ms, 240ms}, Case{10s, 800ms}}) {
        UnitTimes times;
        LateResponse late;
        late.delay = c.delay;
        times.on_late(late);
        Transaction transaction;
        times.set(transaction, 100ms);
        EXPECT_EQ(transaction.late_limit, c.late_limit);
        EXPECT_TRUE(transaction.in_order);
    }
    UnitTimes times;
    LateResponse late;
    late.out_of_order_since = Instant{};
    times.on_late(late);
    Transaction transaction;
    times.set(transaction, 100ms);
    EXPECT_FALSE(transaction.in_order);
}

TEST(UnitTimes, TheUsualLatenessIsTheMedianOfTheLastThree) {
    UnitTimes times;
    const auto late = [&](Duration delay) {
        LateResponse response;
        response.delay = delay;
        times.on_late(response);
        return times.usual_lateness();
    };
    EXPECT_EQ(late(120ms), 0ms);
    EXPECT_EQ(late(90s), 0ms) << "perhaps not a late response at all";
    EXPECT_EQ(late(130ms), 130ms);
    EXPECT_EQ(late(2s), 2s);
    EXPECT_EQ(late(2100ms), 2s);
}

TEST(UnitTimes, ALateResponseIsWaitedForWhileTheyUsuallyCome) {
    UnitTimes times;
    const auto patience = [&] {
        Transaction transaction;
        times.set(transaction, 100ms);
        return transaction.patience;
    };
    LateResponse late;
    late.delay = 120ms;
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(patience(), 0ms) << "not known how late they are";
        times.on_missing();
        times.on_late(late);
    }
    EXPECT_EQ(patience(), 150ms);
    times.on_missing();
    EXPECT_EQ(patience(), 0ms) << "the last one did not come";
    times.on_late(late);
    EXPECT_EQ(patience(), 150ms);
    late.out_of_order_since = Instant{};
    times.on_late(late);
    EXPECT_EQ(patience(), 0ms) << "the unit answers other requests meanwhile";
}

TEST(UnitTimes, TheDelayEndsWithTheFirstByteOfTheResponse) {
    Outcome outcome;
    outcome.status = Status::ambiguous;
    outcome.request.response_length = 6;  // a frame of 9 bytes
    outcome.request_end = Instant{} + 10ms;
    outcome.ended_at = Instant{} + 30ms;
    LineConfig stream;
    stream.format.baud = 0;
    EXPECT_EQ(response_delay(stream, outcome), 20ms);
    LineConfig serial;
    serial.format = {10'000, 8, wire::Parity::none, 1};
    EXPECT_EQ(response_delay(serial, outcome), 11ms);
}

}  // namespace unit_times_test
}  // namespace takt::bus
