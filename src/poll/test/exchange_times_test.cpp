// Hand-moved time. The parts alone have a line of 9600 bit/s, a whole line has the 115200 bit/s of its bench.
#include "devices/exchange_times.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>

#include "bench.hpp"

namespace takt::poll {
namespace exchange_times_test {

using namespace test;

/// A read of one register that was answered after `delay`.
struct Answered {
    std::array<std::uint8_t, 4> pdu{0x03, 0x02, 0x00, 0x01};
    bus::Outcome outcome;
    Duration delay{};

    Answered(const bus::LineConfig& config, Duration turnaround) : delay(turnaround) {
        outcome.sent = true;
        outcome.sent_at = at(1s);
        outcome.request_end = outcome.sent_at + config.frame_time(5);
        outcome.ended_at = outcome.request_end + turnaround + config.frame_time(pdu.size());
        outcome.response = wire::ResponseView(pdu);
    }
};

bus::LineConfig serial_line() {
    bus::LineConfig config;
    config.framing = wire::Framing::rtu;
    config.format.baud = 9600;
    return config;
}

TEST(ExchangeTimes, NothingIsMeasuredAtFirst) {
    const auto times = ExchangeTimes().times();
    for (const auto* part : {&times.wire, &times.turnaround, &times.host}) {
        EXPECT_EQ(part->count, 0U);
        EXPECT_TRUE(part->buckets.empty());
    }
}

TEST(ExchangeTimes, WireAndTurnaroundAddUpToTheTimeOfTheTransaction) {
    const auto config = serial_line();
    ExchangeTimes times;
    const Answered answered(config, 7ms);
    times.on_response(config, answered.outcome, answered.delay);
    const auto parts = times.times();
    EXPECT_EQ(parts.wire.count, 1U);
    EXPECT_EQ(parts.turnaround.longest, 7ms);
    EXPECT_EQ(parts.wire.longest + parts.turnaround.longest,
              answered.outcome.ended_at - answered.outcome.sent_at);
}

TEST(ExchangeTimes, ANetworkHasNoTimeOnTheWire) {
    auto config = serial_line();
    config.framing = wire::Framing::tcp;
    ExchangeTimes times;
    const Answered answered(config, 2ms);
    times.on_response(config, answered.outcome, answered.delay);
    EXPECT_EQ(times.times().wire.count, 0U);
    EXPECT_EQ(times.times().turnaround.longest, 2ms);
}

// A pseudo terminal delivers faster than its bit rate says.
TEST(ExchangeTimes, ANegativeTurnaroundIsNone) {
    const auto config = serial_line();
    ExchangeTimes times;
    const Answered answered(config, -3ms);
    times.on_response(config, answered.outcome, answered.delay);
    EXPECT_EQ(times.times().turnaround.longest, 0ms);
}

TEST(ExchangeTimes, LateWakeUpsAreTheTimeOfTheHost) {
    ExchangeTimes times;
    for (int i = 0; i < 99; ++i) times.on_wakeup(100us);
    times.on_wakeup(5ms);
    const auto host = times.times().host;
    EXPECT_EQ(host.count, 100U);
    EXPECT_EQ(host.longest, 5ms);
    EXPECT_GE(host.p50, 100us);
    EXPECT_LE(host.p99, 113us) << "within 12.5 %";
}

TEST(LineTimes, TransactionsThatTakeLongerThanTheirCostAreCounted) {
    auto slow = device(1, {int16("a", 0).read(3).every(100ms), int16("w", 50).write(6).on_change()});
    slow.turnaround = 5ms;
    Bench bench(project({slow, device(2, {int16("b", 0).read(3).every(100ms)})}));
    bench.players[1].turnaround = bench.players[2].turnaround = 5ms;
    bench.run_until(1050ms);
    const auto over = [&](std::size_t request) { return bench.master.line(0).request(request).over_cost; };
    EXPECT_EQ(over(0) + over(1) + over(2), 0U);
    const auto before = bench.master.line(0).request(0).counters.answered;
    bench.players[1].turnaround = bench.players[2].turnaround = 6ms;
    bench.run_until(2s);
    EXPECT_EQ(over(0), bench.master.line(0).request(0).counters.answered - before);
    bench.players[1].dead = true;
    bench.run_until(3s);
    EXPECT_LE(over(0), 11U) << "a time-out is counted as such";
    EXPECT_EQ(over(2), 0U) << "its turnaround is not known: C includes the time-out";
}

TEST(LineTimes, TheTimeOfALineHasThreeParts) {
    Bench bench(project({device(1, {int16("a", 0).read(3).every(100ms)})}));
    bench.players[1].turnaround = 5ms;
    bench.run_until(10s);
    const auto times = bench.master.line(0).line_times();
    const auto& exact = bench.master.line(0).request(0).counters.time;
    EXPECT_EQ(times.wire.count, exact.count());
    EXPECT_EQ(times.turnaround.longest, 5ms);
    EXPECT_EQ(times.wire.longest + times.turnaround.longest, exact.max());
    EXPECT_EQ(times.host.longest, 0ms) << "hand-moved time is punctual";
    bench.now += 40ms;
    const auto due = bench.master.line(0).next_wakeup();
    const auto late = std::max(due, bench.now) - due;
    bench.master.line(0).on_tick(std::max(due, bench.now));
    EXPECT_EQ(bench.master.line(0).line_times().host.longest, late);
}

}  // namespace exchange_times_test
}  // namespace takt::poll
