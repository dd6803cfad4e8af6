#include "takt/bus/outstanding_responses.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "rig.hpp"

namespace takt::bus {
namespace late_response_test {

using test::at;
using test::hex;
using test::mbap;
using test::Rig;
using test::rtu;
using test::transaction;
using namespace std::chrono_literals;

LineConfig tcp_line() {
    return {.framing = wire::Framing::tcp, .margin = 0ms, .in_flight = 3};
}

TEST(AdvisedTimeout, IsAFifthLongerThanTheDelayAndARoundNumber) {
    const struct {
        Duration delay, advised;
    } cases[] = {{0ms, 1ms},        {1ms, 2ms},         {4ms, 5ms},     {7ms, 10ms},
                 {148ms, 200ms},    {60ms, 80ms},       {251ms, 400ms}, {1300ms, 2000ms},
                 {150ms, 200ms},    {412ms, 500ms},     {20s, 30000ms}, {31s, 40000ms},
                 {10000s, 65535ms}, {32700ms, 40000ms}, {50ms, 60ms},   {5001us, 8ms}};
    for (const auto& c : cases) EXPECT_EQ(advised_timeout(c.delay), c.advised) << c.delay.count();
}

TEST(LateResponses, ALateResponseHasTheDelayOfItsOwnRequestOnASerialLine) {
    Rig rig;
    rig.submit(at(0ms), transaction(1, 1, "03 00 6B 00 02", 100ms));
    rig.run_until(at(130ms));
    ASSERT_EQ(rig.last().status, Status::timeout);
    EXPECT_FALSE(rig.engine.take_late());
    const Duration length = wire::transmission_time(test::kLine.format, 9);
    const Instant first_byte = at(rig.sent_at[0].time_since_epoch() + test::kRequest + 148ms);
    rig.receive(first_byte + length, rtu(1, "03 04 11 11 22 22"));
    const auto late = rig.engine.take_late();
    ASSERT_TRUE(late);
    EXPECT_EQ(*late, (LateResponse{.unit = UnitId{1},
                                   .shape = {3, 6},
                                   .at = first_byte + length,
                                   .delay = 148ms,
                                   .wait = 100ms,
                                   .least_delay = 148ms}));
    EXPECT_FALSE(rig.engine.take_late());
    EXPECT_EQ(rig.engine.counters().late_answers, 1U);
    EXPECT_EQ(rig.engine.counters().foreign_frames, 0U);
}

// The response to the first request looks like that to the second. The surplus response shows the delay.
TEST(LateResponses, AfterTheHoldTimeTheResponseIsAmbiguousAndTheSurplusOneShowsTheDelay) {
    Rig rig;
    rig.submit(at(0ms), transaction(1, 1, "03 00 6B 00 02", 20ms));
    rig.run_until(at(100ms));
    rig.submit(rig.now, transaction(2, 1, "03 00 6B 00 02", 20ms));
    rig.run_until(at(110ms));
    rig.now = at(115ms);
    rig.receive(rig.now, rtu(1, "03 04 11 11 22 22"));
    EXPECT_EQ(rig.outcomes.size(), 1U) << "a further response is waited for";
    rig.run_until(at(200ms));
    ASSERT_EQ(rig.last().status, Status::ambiguous);
    EXPECT_EQ(rig.last().ended_at, at(115ms));
    EXPECT_FALSE(rig.engine.take_late());
    rig.receive(at(220ms), rtu(1, "03 04 11 11 22 22"));
    const auto late = rig.engine.take_late();
    ASSERT_TRUE(late);
    const Duration length = wire::transmission_time(test::kLine.format, 9);
    EXPECT_EQ(late->delay, at(220ms) - length - (rig.sent_at[1] + test::kRequest));
    EXPECT_EQ(rig.engine.counters().late_answers, 1U);
}

TEST(LateResponses, OverTcpAnOwnEarlierTransactionIdIsLateAndAnotherIsForeign) {
    Rig rig(tcp_line());
    rig.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01", 100ms));
    rig.run_until(at(120ms));
    ASSERT_EQ(rig.last().status, Status::timeout);
    rig.submit(rig.now, transaction(2, 17, "03 00 6B 00 01", 100ms));
    rig.run_until(at(121ms));
    rig.receive(at(148ms), mbap(1, "0005 11 03 02 1111"));
    EXPECT_EQ(rig.outcomes.size(), 1U) << "not taken for request 2";
    const auto late = rig.engine.take_late();
    ASSERT_TRUE(late);
    EXPECT_EQ(late->delay, 148ms);
    EXPECT_EQ(late->wait, 100ms);
    rig.receive(at(150ms), mbap(1, "0005 11 03 02 1111"));  // once more
    rig.receive(at(150ms), mbap(9, "0005 11 03 02 1111"));
    EXPECT_FALSE(rig.engine.take_late());
    EXPECT_EQ(rig.engine.counters().late_answers, 1U);
    EXPECT_EQ(rig.engine.counters().foreign_frames, 2U);
    rig.receive(at(160ms), mbap(2, "0005 11 03 02 2222"));
    EXPECT_EQ(rig.last().status, Status::ok);
}

// Its second response is 194 ms late, because it had to answer the first request before.
TEST(LateResponses, ADeviceThatAnswersOneRequestAfterTheOtherIsAsSlowAsItsFirstResponse) {
    Rig rig(tcp_line());
    rig.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01", 100ms));
    rig.run_until(at(102ms));
    rig.submit(at(102ms), transaction(2, 17, "03 00 6B 00 01", 100ms));
    rig.run_until(at(147ms));
    rig.receive(at(148ms), mbap(1, "0005 11 03 02 1111"));
    ASSERT_TRUE(rig.engine.take_late());
    rig.now = at(148ms);
    rig.run_until(at(205ms));
    ASSERT_EQ(rig.outcomes.size(), 2U);
    rig.receive(at(296ms), mbap(2, "0005 11 03 02 1111"));
    const auto late = rig.engine.take_late();
    ASSERT_TRUE(late);
    EXPECT_EQ(late->delay, 148ms);
}

TEST(LateResponses, AreForgottenWithTheirConnection) {
    Rig rig(tcp_line());
    rig.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01", 10ms));
    rig.run_until(at(20ms));
    rig.engine.on_link(at(20ms), false);
    rig.engine.on_link(at(21ms), true);
    rig.receive(at(22ms), mbap(1, "0005 11 03 02 1111"));
    EXPECT_FALSE(rig.engine.take_late());
    EXPECT_EQ(rig.engine.counters().foreign_frames, 1U);
}

TEST(LateResponses, AreForgottenAfterSomeTimeAndTheOldestForANewOne) {
    std::array<OutstandingResponse, 4> memory;
    OutstandingResponses outstanding(memory);
    const auto add = [&](std::uint16_t id) {
        outstanding.add({.unit = UnitId{1},
                         .wire_id = id,
                         .shape = {static_cast<std::uint8_t>(id == 50 ? 4 : 3), id},
                         .end = at(0s),
                         .expired_at = at(0s),
                         .hold_until = at(0s),
                         .forget_at = at(10s)});
    };
    const auto settles = [&](std::uint16_t id, Duration t, const char* pdu = "03 04 11 11 22 22") {
        return outstanding.settle(UnitId{1}, frame_shape(hex(pdu)), id, at(t), at(t)) != Lateness::none;
    };
    for (std::uint16_t id = 10; id <= 50; id += 10) add(id);
    EXPECT_FALSE(outstanding.expects(10));
    EXPECT_TRUE(outstanding.expects(20));
    EXPECT_TRUE(outstanding.expects(19)) << "easily confused";
    EXPECT_FALSE(settles(10, 1s));
    EXPECT_TRUE(settles(20, 10s - 1ns));
    EXPECT_FALSE(settles(30, 10s));
    EXPECT_EQ(outstanding.settle(UnitId{2}, frame_shape(hex("03 04 11 11 22 22")), 40, at(1s), at(1s)),
              Lateness::none)
        << "another unit";
    EXPECT_FALSE(settles(40, 1s, "04 04 11 11 22 22")) << "another function";
    EXPECT_TRUE(settles(40, 1s, "83 02")) << "an exception is an answer";
}

// A faulty server answers once more with another id, while the next request is in flight.
TEST(LateResponses, AnIdThatIsEasilyConfusedWithThatOfTheRequestBeforeIsForeign) {
    const std::function<std::uint16_t(std::uint16_t)> faults[] = {
        [](auto id) { return static_cast<std::uint16_t>(id + 1); },
        [](auto id) { return static_cast<std::uint16_t>(id - 1); },
        [](auto id) { return static_cast<std::uint16_t>(id << 8U | id >> 8U); },
        [](auto) { return std::uint16_t{0}; },
    };
    for (std::size_t k = 0; k < std::size(faults); ++k) {
        Rig rig(tcp_line());
        for (unsigned n = 1; n <= 500; ++n) {
            rig.submit(rig.now, transaction(n, 17, "03 00 6B 00 01", 10ms));
            rig.transmit(rig.now);
            const auto& request = rig.sent.back();
            const auto own = static_cast<std::uint16_t>(request[0] << 8U | request[1]);
            rig.receive(rig.now, test::frame(own, "0005 11 03 02 1111"));
            rig.submit(rig.now, transaction(n, 17, "03 00 6C 00 01", 10ms));
            rig.transmit(rig.now);
            rig.receive(rig.now, test::frame(faults[k](own), "0005 11 03 02 1111"));  // once more
            ASSERT_EQ(rig.outcomes.size(), 2 * n - 1) << "fault " << k << ", id " << own;
            const auto next = static_cast<std::uint16_t>(rig.sent.back()[0] << 8U | rig.sent.back()[1]);
            rig.receive(rig.now, test::frame(next, "0005 11 03 02 2222"));
            ASSERT_EQ(rig.last().status, Status::ok);
        }
        EXPECT_EQ(rig.engine.counters().foreign_frames, 500U);
    }
}

// An id that may still be answered is not used again, nor one that is easily confused with it.
TEST(LateResponses, ATransactionIdThatIsOwedAResponseIsSkipped) {
    Rig rig(tcp_line());
    rig.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01", 1ms));
    rig.run_until(at(2ms));
    ASSERT_EQ(rig.last().status, Status::timeout);
    std::set<std::uint16_t> used;
    for (int i = 0; i < 35'000; ++i) {  // the ids 2 and 65535 would be among them
        rig.submit(rig.now, transaction(2, 17, "03 00 6B 00 01", 1ms));
        rig.transmit(rig.now);
        const auto id = static_cast<std::uint16_t>(rig.sent.back()[0] << 8U | rig.sent.back()[1]);
        ASSERT_FALSE(easily_confused(id, 1)) << i;
        used.insert(id);
        rig.receive(rig.now, test::frame(id, "0005 11 03 02 1111"));
        rig.sent.clear();
    }
    EXPECT_GT(used.size(), 34'000U);
}

}  // namespace late_response_test
}  // namespace takt::bus
