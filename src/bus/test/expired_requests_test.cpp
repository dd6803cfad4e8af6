#include "takt/bus/expired_requests.hpp"

#include <gtest/gtest.h>

#include "rig.hpp"

namespace takt::bus {
namespace {

using test::at;
using test::hex;
using test::Rig;
using test::rtu;
using test::transaction;
using namespace std::chrono_literals;

LineConfig tcp_line() {
    return {.framing = wire::Framing::tcp, .margin = 0ms, .in_flight = 3};
}

std::string tcp(const char* id, const char* rest) {
    return std::string(id) + " 0000 " + rest;
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

TEST(ExpiredRequests, ALateResponseHasTheDelayOfItsOwnRequestOnASerialLine) {
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
    EXPECT_EQ(
        *late,
        (LateResponse{
            .unit = UnitId{1}, .function = 3, .at = first_byte + length, .delay = 148ms, .wait = 100ms}));
    EXPECT_FALSE(rig.engine.take_late());
    EXPECT_EQ(rig.engine.counters().late_answers, 1U);
    EXPECT_EQ(rig.engine.counters().foreign_frames, 0U);
}

// The response to the first request looks like that to the second. The surplus response shows the delay.
TEST(ExpiredRequests, AResponseAfterTheLateLimitShiftsTheOthersAndIsNamedAtTheFirstSurplus) {
    Rig rig;
    rig.submit(at(0ms), transaction(1, 1, "03 00 6B 00 02", 20ms));
    rig.run_until(at(100ms));
    rig.submit(rig.now, transaction(2, 1, "03 00 6B 00 02", 20ms));
    rig.run_until(at(110ms));
    rig.receive(at(115ms), rtu(1, "03 04 11 11 22 22"));
    ASSERT_EQ(rig.last().status, Status::ok);
    EXPECT_FALSE(rig.engine.take_late());
    rig.now = at(115ms);
    rig.run_until(at(200ms));
    rig.receive(at(220ms), rtu(1, "03 04 11 11 22 22"));
    const auto late = rig.engine.take_late();
    ASSERT_TRUE(late);
    const Duration length = wire::transmission_time(test::kLine.format, 9);
    EXPECT_EQ(late->delay, at(220ms) - length - (rig.sent_at[1] + test::kRequest));
    EXPECT_EQ(rig.engine.counters().late_answers, 1U);
}

TEST(ExpiredRequests, OverTcpAnOwnEarlierTransactionIdIsLateAndAnotherIsForeign) {
    Rig rig(tcp_line());
    rig.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01", 100ms));
    rig.run_until(at(120ms));
    ASSERT_EQ(rig.last().status, Status::timeout);
    rig.submit(rig.now, transaction(2, 17, "03 00 6B 00 01", 100ms));
    rig.run_until(at(121ms));
    rig.receive(at(148ms), tcp("0001", "0005 11 03 02 1111"));
    EXPECT_EQ(rig.outcomes.size(), 1U) << "not taken for request 2";
    const auto late = rig.engine.take_late();
    ASSERT_TRUE(late);
    EXPECT_EQ(late->delay, 148ms);
    EXPECT_EQ(late->wait, 100ms);
    rig.receive(at(150ms), tcp("0001", "0005 11 03 02 1111"));  // once more
    rig.receive(at(150ms), tcp("0009", "0005 11 03 02 1111"));
    EXPECT_FALSE(rig.engine.take_late());
    EXPECT_EQ(rig.engine.counters().late_answers, 1U);
    EXPECT_EQ(rig.engine.counters().foreign_frames, 2U);
    rig.receive(at(160ms), tcp("0002", "0005 11 03 02 2222"));
    EXPECT_EQ(rig.last().status, Status::ok);
}

// Its second response is 194 ms late, because it had to answer the first request before.
TEST(ExpiredRequests, ADeviceThatAnswersOneRequestAfterTheOtherIsAsSlowAsItsFirstResponse) {
    Rig rig(tcp_line());
    rig.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01", 100ms));
    rig.run_until(at(102ms));
    rig.submit(at(102ms), transaction(2, 17, "03 00 6B 00 01", 100ms));
    rig.run_until(at(147ms));
    rig.receive(at(148ms), tcp("0001", "0005 11 03 02 1111"));
    ASSERT_TRUE(rig.engine.take_late());
    rig.now = at(148ms);
    rig.run_until(at(205ms));
    ASSERT_EQ(rig.outcomes.size(), 2U);
    rig.receive(at(296ms), tcp("0002", "0005 11 03 02 1111"));
    const auto late = rig.engine.take_late();
    ASSERT_TRUE(late);
    EXPECT_EQ(late->delay, 148ms);
}

TEST(ExpiredRequests, AreForgottenWithTheirConnection) {
    Rig rig(tcp_line());
    rig.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01", 10ms));
    rig.run_until(at(20ms));
    rig.engine.on_link(at(20ms), false);
    rig.engine.on_link(at(21ms), true);
    rig.receive(at(22ms), tcp("0001", "0005 11 03 02 1111"));
    EXPECT_FALSE(rig.engine.take_late());
    EXPECT_EQ(rig.engine.counters().foreign_frames, 1U);
}

TEST(ExpiredRequests, AreForgottenAfterSomeTimeAndTheOldestForANewOne) {
    ExpiredRequests expired;
    const auto add = [&](std::uint16_t id) {
        expired.add({.unit = UnitId{1}, .shape = {3, 6}, .wire_id = id, .end = at(0s), .expired_at = at(0s)});
    };
    const auto settles = [&](std::uint16_t id, Duration t) {
        return expired.settle(UnitId{1}, hex("03 04 11 11 22 22"), id, at(t), at(t));
    };
    for (std::uint16_t id = 1; id <= ExpiredRequests::kCapacity + 1; ++id) add(id);
    EXPECT_FALSE(expired.expects(1));
    EXPECT_TRUE(expired.expects(2));
    EXPECT_FALSE(settles(1, 1s));
    EXPECT_TRUE(settles(2, ExpiredRequests::kRemembered));
    EXPECT_FALSE(settles(3, ExpiredRequests::kRemembered + 1ns));
    EXPECT_FALSE(expired.settle(UnitId{2}, hex("03 04 11 11 22 22"), 4, at(1s), at(1s))) << "another unit";
    EXPECT_FALSE(expired.settle(UnitId{1}, hex("04 04 11 11 22 22"), 4, at(1s), at(1s)))
        << "another function";
    EXPECT_TRUE(expired.settle(UnitId{1}, hex("83 02"), 4, at(1s), at(1s))) << "an exception is an answer";
}

// A transaction id that may still be answered is not used again.
TEST(ExpiredRequests, ATransactionIdThatIsOwedAResponseIsSkipped) {
    Rig rig(tcp_line());
    rig.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01", 1ms));
    rig.run_until(at(2ms));
    ASSERT_EQ(rig.last().status, Status::timeout);
    for (int i = 2; i <= 65536; ++i) {  // the ids 2 to 65535, then 0
        rig.submit(rig.now, transaction(2, 17, "03 00 6B 00 01", 1ms));
        rig.transmit(rig.now);
        auto answer = rig.sent.back();
        answer.resize(4);
        for (const auto byte : hex("0005 11 03 02 1111")) answer.push_back(byte);
        rig.receive(rig.now, answer);
    }
    ASSERT_EQ(rig.outcomes.size(), 65536U);
    rig.submit(rig.now, transaction(3, 17, "03 00 6B 00 01", 1ms));
    rig.transmit(rig.now);
    EXPECT_EQ(rig.sent.back()[1], 2U) << "not 1";
}

}  // namespace
}  // namespace takt::bus
