// Hand-moved time: 9600 bit/s, 8N1, so a character takes 1.0417 ms.
#include "../exchange_times.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>

#include "bench.hpp"

namespace takt::poll {
namespace {

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

}  // namespace
}  // namespace takt::poll
