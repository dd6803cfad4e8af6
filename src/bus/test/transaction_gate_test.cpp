#include "takt/bus/transaction_gate.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <vector>

namespace takt::bus {
namespace transaction_gate_test {

using namespace std::chrono_literals;

constexpr Instant at(Duration since_start) {
    return Instant{} + since_start;
}

TEST(TransactionGate, CountsTheIntervalFromTheEnd) {
    TransactionGate gate(1, 1s);
    EXPECT_TRUE(gate.admits(at(0s)));
    gate.started(at(0s));
    EXPECT_FALSE(gate.admits(at(2s)));
    EXPECT_EQ(gate.next_admission(at(2s)), kNever) << "it must end first";
    gate.ended(at(3s));
    EXPECT_EQ(gate.next_admission(at(3s)), at(4s));
    EXPECT_FALSE(gate.admits(at(4s) - 1ns));
    EXPECT_TRUE(gate.admits(at(4s)));
}

TEST(TransactionGate, ATransactionWithoutATokenEmptiesTheBucket) {
    TransactionGate gate(1, 1s);
    gate.started(at(0s));
    gate.ended(at(0s));
    gate.started(at(900ms));  // the line was free
    gate.ended(at(1000ms));
    EXPECT_EQ(gate.next_admission(at(1000ms)), at(2000ms));
}

TEST(TransactionGate, ABurstGoesAtOnce) {
    TransactionGate gate(3, 100ms);
    for (const Duration start : {0ms, 10ms, 20ms}) {
        EXPECT_TRUE(gate.admits(at(start)));
        gate.started(at(start));
        gate.ended(at(start + 10ms));
    }
    EXPECT_EQ(gate.next_admission(at(30ms)), at(130ms));
    gate.started(at(10s));
    gate.ended(at(10s));
    EXPECT_TRUE(gate.admits(at(10s))) << "never more than three are saved";
    gate.started(at(10s));
    gate.ended(at(10s));
    gate.started(at(10s));
    gate.ended(at(10s));
    EXPECT_EQ(gate.next_admission(at(10s)), at(10s) + 100ms);
}

TEST(TransactionGate, SeveralInFlightStopTheClockOnce) {
    TransactionGate gate(2, 100ms);
    gate.started(at(0ms));
    EXPECT_TRUE(gate.admits(at(10ms))) << "the second of the burst";
    gate.started(at(10ms));
    gate.ended(at(50ms));
    EXPECT_EQ(gate.next_admission(at(50ms)), kNever);
    gate.ended(at(70ms));
    EXPECT_EQ(gate.next_admission(at(70ms)), at(170ms));
}

TEST(TransactionGate, ARepetitionTakesNoTokenAndStopsTheClock) {
    TransactionGate gate(1, 100ms);
    gate.started(at(0ms));
    gate.ended(at(10ms));
    gate.resumed(at(60ms));
    gate.ended(at(80ms));
    EXPECT_EQ(gate.next_admission(at(80ms)), at(130ms));
}

TEST(TransactionGate, TheEndMayLieInTheFuture) {
    TransactionGate gate(1, 100ms);
    gate.started(at(0ms));
    gate.ended(at(40ms));
    EXPECT_EQ(gate.next_admission(at(30ms)), at(140ms));
}

TEST(TransactionGate, WithoutAnIntervalItAdmitsAlways) {
    TransactionGate gate(1, 0ms);
    gate.started(at(5ms));
    EXPECT_TRUE(gate.admits(at(6ms)));
    gate.ended(at(7ms));
    EXPECT_TRUE(gate.admits(at(7ms)));
}

TEST(TransactionGate, AProductBeyondAnInstantIsCut) {
    TransactionGate gate(1'000'000, 24h);
    for (int i = 0; i < 100; ++i) {
        EXPECT_TRUE(gate.admits(at(1s * i)));
        gate.started(at(1s * i));
        gate.ended(at(1s * i));
    }
}

// From the first start to the n-th of those admitted, others have at least (n - burst) intervals of the line.
RC_GTEST_PROP(TransactionGate, LeavesTheLineToOthers, ()) {
    const auto burst = *rc::gen::inRange<std::uint32_t>(1, 5);
    constexpr Duration kInterval = 10ms;
    TransactionGate gate(burst, kInterval);
    Instant now = at(0ms);
    std::vector<Duration> taken;  // line time before each admitted start
    std::vector<Instant> starts;
    Duration total{};
    for (const int length : *rc::gen::container<std::vector<int>>(rc::gen::inRange(0, 60))) {
        now += *rc::gen::inRange(0, 40) * 1ms;
        if (*rc::gen::inRange(0, 3) > 0) now = std::max(now, gate.next_admission(now));
        if (gate.admits(now)) {
            starts.push_back(now);
            taken.push_back(total);
        }
        gate.started(now);
        now += length * 1ms;
        total += length * 1ms;
        gate.ended(now);
        for (std::size_t first = 0; first < starts.size(); ++first) {
            const std::size_t last = starts.size() - 1;
            const Duration left = starts[last] - starts[first] - (taken[last] - taken[first]);
            const auto beyond =
                static_cast<std::int64_t>(last - first) - static_cast<std::int64_t>(burst) + 1;
            if (beyond > 0) RC_ASSERT(left >= kInterval * beyond);
        }
    }
}

}  // namespace transaction_gate_test
}  // namespace takt::bus
