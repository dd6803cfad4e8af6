#include "takt/bus/transaction_engine.hpp"

#include <gtest/gtest.h>

#include "rig.hpp"

namespace takt::bus {
namespace transaction_engine_test {

using namespace test;

TEST(TransactionEngine, SendsTheGoldenRequestAndTakesItsResponse) {
    Rig rig;
    rig.submit(at(10ms), transaction(7, 16, "03 00 00 00 02"));
    rig.now = at(10ms);
    rig.run_until(at(12ms));
    ASSERT_EQ(rig.sent.size(), 1U);
    EXPECT_EQ(rig.sent[0], hex("10 03 00 00 00 02 C7 4A"));
    rig.receive(at(25ms), "10 03 04 00 00 3F 80 EB 62");
    ASSERT_EQ(rig.outcomes.size(), 1U);
    EXPECT_EQ(rig.last().id, 7U);
    EXPECT_EQ(rig.last().status, Status::ok);
    const Bytes response = rig.last().response.pdu();
    EXPECT_EQ(std::vector(response.begin(), response.end()), hex("03 04 00 00 3F 80"));
    EXPECT_EQ(rig.last().sent_at, at(10ms));
    EXPECT_EQ(rig.last().request_end, at(10ms + kRequest));
    EXPECT_EQ(rig.last().ended_at, at(25ms));
    EXPECT_EQ(rig.engine.counters().answered, 1U);
    EXPECT_EQ(rig.engine.counters().time.max(), 15ms);
    EXPECT_TRUE(rig.engine.idle());
}

TEST(TransactionEngine, KeepsTheSilenceSinceTheLastByteOfAnyone) {
    Rig rig;
    rig.submit(at(0ms), transaction(1, 1, "03 00 00 00 01"));
    rig.receive(at(1ms), "FF");  // pushes the silence that began with the link
    rig.run_until(at(1ms + kT35 - 1ns));
    EXPECT_TRUE(rig.sent.empty());
    rig.run_until(at(1ms + kT35));
    ASSERT_EQ(rig.sent.size(), 1U);
    EXPECT_EQ(rig.engine.counters().unsolicited_bytes, 1U);

    rig.receive(at(20ms), rtu(1, "03 02 00 01"));
    rig.submit(at(20ms), transaction(2, 1, "03 00 00 00 01"));
    rig.now = at(20ms);
    rig.run_until(at(40ms));
    ASSERT_EQ(rig.sent_at.size(), 2U);
    EXPECT_EQ(rig.sent_at[1], at(20ms + kT35));
}

TEST(TransactionEngine, KeepsTheGapsOfTheLine) {
    struct Case {
        Duration frame_gap, request_gap, from_start_to_start;
    };
    constexpr Duration kAnswered = 12ms;  // after the start of the first request
    constexpr Case kCases[] = {
        {0ms, 0ms, kAnswered + kT35}, {1ms, 0ms, kAnswered + kT35},
        {5ms, 0ms, kAnswered + 5ms},  {0ms, 30ms, 30ms},
        {5ms, 15ms, kAnswered + 5ms},
    };
    for (const auto& c : kCases) {
        auto config = kLine;
        config.frame_gap = c.frame_gap;
        config.request_gap = c.request_gap;
        Rig rig(config);
        rig.now = at(100ms);
        rig.submit(rig.now, transaction(1, 1, "03 00 00 00 01"));
        rig.run_until(at(100ms + kAnswered));
        rig.receive(at(100ms + kAnswered), rtu(1, "03 02 00 01"));
        rig.submit(rig.now, transaction(2, 1, "03 00 00 00 01"));
        rig.run_until(at(200ms));
        ASSERT_EQ(rig.sent_at.size(), 2U);
        EXPECT_EQ(rig.sent_at[1] - rig.sent_at[0], c.from_start_to_start);
    }
}

TEST(TransactionEngine, OneDeadlineForAllBytesThatArrive) {
    Rig rig;
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 1, "03 00 00 00 02", 100ms));
    rig.run_until(at(11ms));
    // 9 characters of response, 2 ms margin.
    const Instant deadline = at(10ms + kRequest + 100ms + 4687500ns + 2ms);
    EXPECT_EQ(rig.engine.next_wakeup(), deadline);
    for (Duration t = 15ms; at(t) < deadline; t += 1500us) {
        rig.run_until(at(t));
        rig.receive(at(t), "01");
    }
    rig.run_until(deadline - 1ns);
    EXPECT_TRUE(rig.outcomes.empty());
    rig.run_until(deadline);
    ASSERT_EQ(rig.outcomes.size(), 1U);
    EXPECT_EQ(rig.last().ended_at, deadline);
    EXPECT_TRUE(rig.last().sent);
    EXPECT_TRUE(rig.last().response.empty());
}

TEST(TransactionEngine, NoDeviceIsExpectedToAnswerBeforeTheSilence) {
    Rig rig;
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 1, "03 00 00 00 02", 500us));
    rig.run_until(at(11ms));
    EXPECT_EQ(rig.engine.next_wakeup(), at(10ms + kRequest + kT35 + 4687500ns + 2ms));
}

TEST(TransactionEngine, JudgesWhatComes) {
    struct Case {
        const char* what;
        const char* request;
        std::vector<std::uint8_t> received;
        std::optional<Status> status;  // nothing: the waiting goes on
        std::uint8_t exception = 0;
    };
    const Case kCases[] = {
        {"the answer", "03 00 00 00 01", rtu(1, "03 02 00 01"), Status::ok},
        {"another unit", "03 00 00 00 01", rtu(2, "03 02 00 01"), std::nullopt},
        {"another function", "03 00 00 00 01", rtu(1, "04 02 00 01"), std::nullopt},
        {"exception of another function", "03 00 00 00 01", rtu(1, "84 02"), std::nullopt},
        {"exception 2", "03 00 00 00 01", rtu(1, "83 02"), Status::exception, 2},
        {"exception 0", "03 00 00 00 01", rtu(1, "83 00"), Status::exception, 0},
        {"exception 0xFF", "03 00 00 00 01", rtu(1, "83 FF"), Status::exception, 0xFF},
        {"too few registers", "03 00 00 00 02", rtu(1, "03 02 00 01"), Status::unexpected_reply},
        {"too many registers", "03 00 00 00 01", rtu(1, "03 04 00 01 00 02"), Status::unexpected_reply},
        {"echo of another value", "06 00 01 00 03", rtu(1, "06 00 01 00 04"), Status::unexpected_reply},
        {"echo of another start", "10 00 01 00 01 02 00 07", rtu(1, "10 00 02 00 01"),
         Status::unexpected_reply},
        {"garbled, as long as the answer", "03 00 00 00 01", hex("01 03 02 00 01 FF FF"),
         Status::bad_checksum},
        {"garbled, shorter", "03 00 00 00 01", hex("01 03 02 00"), std::nullopt},
        {"noise", "03 00 00 00 01", hex("FF FF 00 FF FF FF FF FF FF FF FF FF"), std::nullopt},
    };
    for (const auto& c : kCases) {
        Rig rig;
        rig.now = at(10ms);
        rig.submit(rig.now, transaction(1, 1, c.request));
        rig.run_until(at(20ms));
        rig.receive(at(20ms), c.received);
        rig.run_until(at(60ms));
        ASSERT_EQ(rig.outcomes.size(), c.status ? 1U : 0U) << c.what;
        if (c.status) {
            EXPECT_EQ(rig.last().status, *c.status) << c.what;
            EXPECT_EQ(rig.last().exception, c.exception) << c.what;
            continue;
        }
        rig.receive(at(70ms), rtu(1, "03 02 00 07"));
        ASSERT_EQ(rig.outcomes.size(), 1U) << c.what;
        EXPECT_EQ(rig.last().status, Status::ok) << c.what;
    }
}

TEST(TransactionEngine, TheAnswerMayFollowAForeignFrameAtOnce) {
    Rig rig;
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 1, "03 00 00 00 01"));
    rig.run_until(at(20ms));
    auto lump = rtu(2, "03 02 00 01");
    const auto answer = rtu(1, "03 02 00 07");
    lump.insert(lump.end(), answer.begin(), answer.end());
    rig.receive(at(20ms), lump);
    ASSERT_EQ(rig.outcomes.size(), 1U);
    EXPECT_EQ(rig.last().response.registers()[0], 7);
}

TEST(TransactionEngine, AnAdapterMayDeliverInLumps) {
    Rig rig;
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 1, "03 00 00 00 01"));
    rig.run_until(at(20ms));
    rig.receive(at(20ms), "01 03 02");
    rig.run_until(at(36ms));
    rig.receive(at(36ms), "00 07 F9 86");
    ASSERT_EQ(rig.outcomes.size(), 1U);
    EXPECT_EQ(rig.last().status, Status::ok);
}

/// Request 1 to unit 1 times out at 10 ms + request + 50 ms + response + 2 ms, about 70 ms; its answer may
/// come 50 ms later still.
void time_out(Rig& rig) {
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 1, "03 00 00 00 02", 50ms));
    rig.run_until(at(75ms));
    EXPECT_EQ(rig.outcomes.size(), 1U);
    EXPECT_EQ(rig.last().status, Status::timeout);
}

TEST(TransactionEngine, AfterATimeOutOnlyAnswersThatCannotBeMistaken) {
    struct Case {
        const char* what;
        std::uint8_t unit;
        const char* request;
        bool waits;
    };
    constexpr Case kCases[] = {
        {"the same again", 1, "03 00 00 00 02", true},  {"another address", 1, "03 00 50 00 02", true},
        {"another length", 1, "03 00 00 00 03", false}, {"another function", 1, "04 00 00 00 02", false},
        {"another unit", 2, "03 00 00 00 02", false},
    };
    for (const auto& c : kCases) {
        Rig rig;
        time_out(rig);
        const Instant limit = rig.last().ended_at + 50ms;
        rig.sent_at.clear();
        rig.submit(rig.now, transaction(2, c.unit, c.request, 10ms));
        rig.run_until(at(200ms));
        ASSERT_EQ(rig.sent_at.size(), 1U) << c.what;
        EXPECT_EQ(rig.sent_at[0], c.waits ? limit : at(75ms)) << c.what;
    }
}

TEST(TransactionEngine, TheLateAnswerOnceSeenFreesItsUnit) {
    Rig rig;
    time_out(rig);
    rig.submit(rig.now, transaction(2, 1, "03 00 50 00 02", 50ms));
    rig.receive(at(80ms), rtu(1, "03 04 11 11 22 22"));
    EXPECT_EQ(rig.outcomes.size(), 1U);  // not taken for request 2
    rig.now = at(80ms);
    rig.run_until(at(90ms));
    EXPECT_EQ(rig.sent_at.back(), at(80ms + kT35));
    EXPECT_EQ(rig.engine.counters().late_answers, 1U);
}

TEST(TransactionEngine, ALateAnswerDuringAnotherTransactionIsDropped) {
    Rig rig;
    time_out(rig);
    rig.submit(rig.now, transaction(2, 1, "03 00 50 00 03", 50ms));
    rig.run_until(at(80ms));
    rig.receive(at(85ms), rtu(1, "03 04 11 11 22 22"));
    EXPECT_EQ(rig.outcomes.size(), 1U);
    rig.receive(at(95ms), rtu(1, "03 06 00 01 00 02 00 03"));
    ASSERT_EQ(rig.outcomes.size(), 2U);
    EXPECT_EQ(rig.last().status, Status::ok);
    EXPECT_EQ(rig.last().id, 2U);
}

TEST(TransactionEngine, AnExceptionThatMayBeLateHoldsUpWhatLooksLikeEither) {
    Rig rig;
    time_out(rig);
    rig.submit(rig.now, transaction(2, 1, "03 00 50 00 03", 50ms));
    rig.run_until(at(80ms));
    rig.receive(at(85ms), rtu(1, "83 02"));
    ASSERT_EQ(rig.outcomes.size(), 2U);
    EXPECT_EQ(rig.last().status, Status::exception);
    EXPECT_GT(rig.engine.earliest_start(UnitId{1}, {3, 8}), at(150ms));
    EXPECT_GT(rig.engine.earliest_start(UnitId{1}, {3, 6}), at(150ms));
    EXPECT_LT(rig.engine.earliest_start(UnitId{1}, {3, 4}), at(90ms));
    EXPECT_LT(rig.engine.earliest_start(UnitId{1}, {4, 8}), at(90ms));
    rig.receive(at(95ms), rtu(1, "03 06 00 01 00 02 00 03"));  // it was request 1's: this is request 2's
    EXPECT_LT(rig.engine.earliest_start(UnitId{1}, {3, 8}), at(100ms));
    EXPECT_LT(rig.engine.earliest_start(UnitId{1}, {3, 6}), at(100ms));
}

TEST(TransactionEngine, AfterAnyFailureTheAnswerMayStillCome) {
    struct Case {
        const char* what;
        std::vector<std::uint8_t> received;
        bool waits;
    };
    const Case kCases[] = {
        {"an answer to something else", rtu(1, "03 02 00 01"), true},
        {"noise", hex("FF FF FF"), true},
        {"the answer, garbled", hex("01 03 04 00 01 00 02 FF FF"), false},
        {"the answer", rtu(1, "03 04 00 01 00 02"), false},
        {"an exception", rtu(1, "83 02"), false},
    };
    for (const auto& c : kCases) {
        Rig rig;
        rig.now = at(10ms);
        rig.submit(rig.now, transaction(1, 1, "03 00 00 00 02", 50ms));
        rig.run_until(at(20ms));
        rig.receive(at(20ms), c.received);
        rig.run_until(at(100ms));
        ASSERT_EQ(rig.outcomes.size(), 1U) << c.what;
        const Instant earliest = rig.engine.earliest_start(UnitId{1}, {3, 6});
        EXPECT_EQ(earliest > at(100ms), c.waits) << c.what;
    }
}

TEST(TransactionEngine, DropsItsOwnEcho) {
    Rig rig;
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 1, "03 00 00 00 01"));
    rig.run_until(at(11ms));
    auto received = rtu(1, "03 00 00 00 01");
    const auto answer = rtu(1, "03 02 00 05");
    received.insert(received.end(), answer.begin(), answer.end());
    rig.receive(at(20ms), received);  // both in one lump, as an adapter delivers them
    ASSERT_EQ(rig.outcomes.size(), 1U);
    EXPECT_EQ(rig.last().status, Status::ok);

    rig.submit(at(20ms), transaction(2, 1, "06 00 01 00 03"));
    rig.now = at(20ms);
    rig.run_until(at(40ms));
    rig.receive(at(40ms), rtu(1, "06 00 01 00 03"));
    EXPECT_EQ(rig.outcomes.size(), 1U);  // the echo alone does not confirm a write
    rig.receive(at(50ms), rtu(1, "06 00 01 00 03"));
    ASSERT_EQ(rig.outcomes.size(), 2U);
    EXPECT_EQ(rig.last().status, Status::ok);
    EXPECT_EQ(rig.engine.counters().echoes, 2U);
}

TEST(TransactionEngine, ASpoiltEchoIsNoAnswer) {
    LineConfig ascii = kLine;
    ascii.framing = wire::Framing::ascii;
    const auto framed = [](std::string_view pdu) {
        const auto frame = wire::encode_frame(wire::Framing::ascii, UnitId{1}, 0, hex(pdu));
        return std::vector<std::uint8_t>(frame.begin(), frame.end());
    };
    Rig rig(ascii);
    rig.submit(rig.now, transaction(1, 1, "03 00 00 00 01"));
    rig.run_until(at(10ms));
    rig.receive(at(10ms), framed("03 00 00 00 01"));
    rig.receive(at(30ms), framed("03 02 00 05"));
    ASSERT_EQ(rig.outcomes.size(), 1U);

    rig.submit(at(30ms), transaction(2, 1, "05 00 01 FF 00"));
    rig.now = at(30ms);
    rig.run_until(at(40ms));
    auto received = framed("05 00 01 FF 00");
    received.insert(received.begin(), ':');  // one character more, and the frame behind it is whole
    rig.receive(at(40ms), received);
    EXPECT_EQ(rig.outcomes.size(), 1U);
    rig.receive(at(50ms), framed("05 00 01 FF 00"));
    ASSERT_EQ(rig.outcomes.size(), 2U);
    EXPECT_EQ(rig.last().status, Status::ok);

    // While the request still goes out, as many bad characters as the answer will have end nothing.
    rig.submit(at(60ms), transaction(3, 1, "01 00 00 00 03"));
    rig.now = at(60ms);
    rig.run_until(at(61ms));
    auto spoilt = framed("01 00 00 00 03");
    spoilt.resize(framed("01 01 00").size() - 1);
    spoilt.push_back('I');
    rig.receive(at(67ms), spoilt);
    EXPECT_EQ(rig.outcomes.size(), 2U);
    rig.receive(at(90ms), framed("01 01 05"));
    ASSERT_EQ(rig.outcomes.size(), 3U);
    EXPECT_EQ(rig.last().status, Status::ok);
}

TEST(TransactionEngine, ABroadcastIsOverAfterItsTurnaround) {
    Rig rig;
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 0, "06 00 01 00 03"));
    rig.run_until(at(10ms + kRequest + 100ms - 1ns));
    EXPECT_TRUE(rig.outcomes.empty());
    rig.run_until(at(10ms + kRequest + 100ms));
    ASSERT_EQ(rig.outcomes.size(), 1U);
    EXPECT_EQ(rig.last().status, Status::ok);
    EXPECT_EQ(rig.engine.counters().broadcasts, 1U);
    rig.submit(rig.now, transaction(2, 0, "03 00 00 00 01"));
    EXPECT_EQ(rig.refused, std::vector<TransactionId>{2});
}

TEST(TransactionEngine, TheLinkLostEndsEverythingOnce) {
    Rig rig;
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 1, "06 00 01 00 03"));
    rig.run_until(at(11ms));
    rig.engine.on_link(at(12ms), false);
    rig.collect();
    ASSERT_EQ(rig.outcomes.size(), 1U);
    EXPECT_EQ(rig.last().status, Status::link_lost);
    EXPECT_TRUE(rig.last().sent);
    EXPECT_EQ(rig.engine.next_wakeup(), kNever);
    rig.submit(at(13ms), transaction(2, 1, "06 00 01 00 03"));
    EXPECT_EQ(rig.refused, std::vector<TransactionId>{2});
    rig.engine.on_link(at(20ms), true);
    rig.submit(at(20ms), transaction(3, 1, "03 00 00 00 01"));
    rig.engine.on_link(at(20ms), false);  // before the silence was over
    rig.collect();
    EXPECT_FALSE(rig.last().sent);
}

TEST(TransactionEngine, AJabberingStationMakesTheLineBusy) {
    Rig rig;
    rig.submit(at(0ms), transaction(1, 1, "03 00 00 00 01"));
    for (Duration t = 1ms; t < 2s && rig.outcomes.empty(); t += 1ms) {
        rig.run_until(at(t));
        rig.receive(at(t), "55");
    }
    ASSERT_EQ(rig.outcomes.size(), 1U);
    EXPECT_EQ(rig.last().status, Status::line_busy);
    EXPECT_FALSE(rig.last().sent);
    EXPECT_TRUE(rig.sent.empty());
    EXPECT_LT(rig.last().ended_at, at(1100ms));
}

TEST(TransactionEngine, AsciiHasNoSilences) {
    Rig rig(
        LineConfig{.framing = wire::Framing::ascii,
                   .format = {.baud = 9600, .data_bits = 7, .parity = wire::Parity::even, .stop_bits = 1}});
    rig.submit(at(0ms), transaction(1, 1, "03 00 00 00 01"));
    rig.run_until(at(1ms));
    ASSERT_EQ(rig.sent.size(), 1U);
    EXPECT_EQ(std::string(rig.sent[0].begin(), rig.sent[0].end()), ":010300000001FB\r\n");
    EXPECT_EQ(rig.sent_at[0], at(0ms));
    const std::string_view answer = ":0103020005F5\r\n";
    rig.receive(at(60ms), std::vector<std::uint8_t>(answer.begin(), answer.end()));
    ASSERT_EQ(rig.outcomes.size(), 1U);
    EXPECT_EQ(rig.last().status, Status::ok);
}

LineConfig tcp_line() {
    return {.framing = wire::Framing::tcp, .in_flight = 3};
}

TEST(TransactionEngine, TcpAnswersComeInAnyOrder) {
    Rig rig(tcp_line());
    for (TransactionId id = 1; id <= 4; ++id) rig.submit(at(0ms), transaction(id, 17, "03 00 6B 00 03"));
    EXPECT_EQ(rig.refused, std::vector<TransactionId>{4});
    rig.run_until(at(1ms));
    ASSERT_EQ(rig.sent.size(), 3U);
    EXPECT_EQ(rig.sent[0], mbap(1, "0006 11 03 006B 0003"));
    EXPECT_EQ(rig.sent[2], mbap(3, "0006 11 03 006B 0003"));
    rig.receive(at(2ms), mbap(3, "0009 11 03 06 022B 0064 007F"));
    rig.receive(at(3ms), "0009 0000 0009 11 03 06 022B 0064 007F");  // unsolicited
    rig.receive(at(3ms), mbap(2, "0009 12 03 06 022B 0064 007F"));   // another unit
    rig.receive(at(3ms), mbap(2, "0009 11 04 06 022B 0064 007F"));   // another function
    auto both = mbap(1, "0003 11 83 02");
    for (const auto byte : mbap(2, "0005 11 03 02 022B")) both.push_back(byte);
    rig.receive(at(4ms), both);
    ASSERT_EQ(rig.outcomes.size(), 3U);
    EXPECT_EQ(rig.outcomes[0].id, 3U);
    EXPECT_EQ(rig.outcomes[1].status, Status::exception);
    EXPECT_EQ(rig.outcomes[2].status, Status::unexpected_reply);
    EXPECT_EQ(rig.engine.counters().foreign_frames, 3U);
}

// The least storage that the contract allows, with the longest frames both ways; sanitizers check its bounds.
TEST(TransactionCore, WorksInTheLeastStorage) {
    for (const auto framing : {wire::Framing::rtu, wire::Framing::ascii, wire::Framing::tcp}) {
        LineConfig config = kLine;
        config.framing = framing;
        config.in_flight = 5;
        std::vector<TransactionSlot> slots(1);
        std::vector<std::uint8_t> pdus(wire::kMaxPdu);
        std::vector<std::uint8_t> sending(TransactionStorage::sending_size(framing));
        std::vector<std::uint8_t> receiving(TransactionStorage::receiving_size(framing));
        std::vector<OutstandingResponse> outstanding(1);
        TransactionCore engine(config, {slots, pdus, sending, receiving, outstanding});
        EXPECT_EQ(engine.config().in_flight, 1U);
        engine.on_link(at(0ms), true);
        wire::Pdu longest{0x41};  // an unknown function
        longest.resize(wire::kMaxPdu);
        ASSERT_TRUE(engine.submit(at(1s), {.id = 7, .unit = UnitId{1}, .request = longest}));
        EXPECT_FALSE(engine.can_submit());
        EXPECT_EQ(engine.transmit(at(1s)).size(), wire::frame_length(framing, wire::kMaxPdu));
        wire::Pdu response = longest;
        response[1] = 0xFF;  // else it would be an echo
        engine.on_bytes(at(1300ms), wire::encode_frame(framing, UnitId{1}, 1, response.span()).span());
        engine.on_tick(at(1340ms));
        const auto outcome = engine.take_outcome();
        ASSERT_TRUE(outcome) << wire::name(framing);
        EXPECT_EQ(outcome->status, Status::ok) << wire::name(framing);
        EXPECT_TRUE(std::ranges::equal(outcome->response.pdu(), response));
        EXPECT_TRUE(engine.idle());
    }
}

// Storage for reads of one register: longer requests are rejected, longer frames skipped.
TEST(TransactionCore, ShortRequestsNeedLittleStorage) {
    constexpr std::size_t kLongest = 5;
    std::vector<TransactionSlot> slots(2);
    std::vector<std::uint8_t> pdus(2 * kLongest);
    std::vector<std::uint8_t> sending(TransactionStorage::sending_size(wire::Framing::tcp, kLongest));
    std::vector<std::uint8_t> receiving(TransactionStorage::receiving_size(wire::Framing::tcp, kLongest));
    EXPECT_EQ(receiving.size(), 12U);
    TransactionCore engine(tcp_line(), {slots, pdus, sending, receiving, {}, kLongest});
    engine.on_link(at(0ms), true);
    EXPECT_EQ(engine.submit(at(0ms), transaction(1, 17, "06 00 6B 00 03 00")).error().code, Code::too_long);
    ASSERT_TRUE(engine.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01")));
    ASSERT_TRUE(engine.submit(at(0ms), transaction(2, 17, "03 00 6C 00 01")));
    EXPECT_EQ(engine.transmit(at(0ms)).size(), 12U);
    EXPECT_EQ(engine.transmit(at(0ms)).size(), 12U);
    engine.on_bytes(at(1ms), hex("0009 0000 0009 11 03 06 0000 0000 0000"));  // unsolicited
    engine.on_bytes(at(1ms), hex("0001 0000 0009 11 03 06 0000"));  // longer than anything that was asked for
    EXPECT_FALSE(engine.take_outcome());
    engine.on_bytes(at(2ms), hex("0000 0000"));
    engine.on_bytes(at(2ms), mbap(2, "0005 11 03 02 BBBB"));
    const auto first = engine.take_outcome();
    const auto second = engine.take_outcome();
    ASSERT_TRUE(first && second);
    EXPECT_EQ(first->id, 1U);
    EXPECT_EQ(first->status, Status::unexpected_reply);
    EXPECT_EQ(second->id, 2U);
    ASSERT_EQ(second->response.registers().size(), 1U);
    EXPECT_EQ(second->response.registers()[0], 0xBBBB);
    EXPECT_EQ(engine.counters().faults, 2U);
    EXPECT_FALSE(engine.must_reconnect());
}

// A slot stays occupied until its outcome is taken.
TEST(TransactionEngine, APlaceIsFreeOnceItsOutcomeIsTaken) {
    TransactionEngineOf<1> engine(tcp_line());
    engine.on_link(at(0ms), true);
    ASSERT_TRUE(engine.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01")));
    engine.cancel_all(at(1ms));
    EXPECT_FALSE(engine.can_submit());
    EXPECT_FALSE(engine.idle());
    EXPECT_EQ(engine.submit(at(1ms), transaction(2, 17, "03 00 6B 00 01")).error().code, Code::queue_full);
    EXPECT_EQ(engine.take_outcome()->id, 1U);
    EXPECT_TRUE(engine.submit(at(1ms), transaction(2, 17, "03 00 6B 00 01")));
}

TEST(TransactionEngine, TcpTakesALateAnswerForNothing) {
    Rig rig(tcp_line());
    rig.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01", 50ms));
    rig.run_until(at(60ms));
    EXPECT_EQ(rig.last().status, Status::timeout);
    EXPECT_EQ(rig.last().ended_at, at(52ms));
    rig.submit(at(60ms), transaction(2, 17, "03 00 6C 00 01", 50ms));
    rig.run_until(at(61ms));
    EXPECT_EQ(rig.sent_at.back(), at(60ms));
    rig.receive(at(62ms), mbap(1, "0005 11 03 02 AAAA"));
    EXPECT_EQ(rig.outcomes.size(), 1U);
    rig.receive(at(63ms), mbap(2, "0005 11 03 02 BBBB"));
    EXPECT_EQ(rig.last().id, 2U);
}

TEST(TransactionEngine, AFrameThatStaysUnfinishedAsksForANewConnection) {
    Rig rig(tcp_line());
    rig.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01", 50ms));
    rig.run_until(at(1ms));
    rig.receive(at(2ms), "0001 0000 00FA 11 03 02 AAAA");  // its header announces 250 bytes, 5 arrive
    EXPECT_FALSE(rig.engine.must_reconnect());
    rig.run_until(at(60ms));
    EXPECT_EQ(rig.last().status, Status::timeout);
    EXPECT_TRUE(rig.engine.must_reconnect());
}

TEST(TransactionEngine, AWrongHeaderAsksForANewConnection) {
    Rig rig(tcp_line());
    rig.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01"));
    rig.run_until(at(1ms));
    rig.receive(at(2ms), "48 54 54 50 2F 31 2E 31");
    EXPECT_TRUE(rig.engine.must_reconnect());
    rig.receive(at(3ms), "0001 0000 0005 11 03 02 AAAA");
    EXPECT_TRUE(rig.outcomes.empty());
    rig.engine.on_link(at(4ms), false);
    rig.collect();
    EXPECT_EQ(rig.last().status, Status::link_lost);
    rig.engine.on_link(at(5ms), true);
    EXPECT_FALSE(rig.engine.must_reconnect());
}

TEST(TransactionEngine, RtuOverAStreamNeedsNoSilence) {
    Rig rig(LineConfig{.framing = wire::Framing::rtu, .format = {.baud = 0}});
    rig.submit(at(0ms), transaction(1, 1, "03 00 00 00 01"));
    rig.run_until(at(0ms));
    ASSERT_EQ(rig.sent.size(), 1U);
    rig.receive(at(1ms), rtu(1, "03 02 00 05"));
    EXPECT_EQ(rig.last().status, Status::ok);
    rig.submit(at(1ms), transaction(2, 1, "06 00 01 00 03"));
    rig.now = at(1ms);
    rig.run_until(at(1ms));
    EXPECT_EQ(rig.sent_at.back(), at(1ms));
    rig.receive(at(2ms), rtu(1, "06 00 01 00 03"));
    EXPECT_EQ(rig.last().status, Status::ok);
}

TEST(TransactionEngine, GivesUpWhatIsCancelled) {
    Rig rig;
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 1, "03 00 00 00 01", 50ms));
    rig.run_until(at(11ms));
    rig.engine.cancel_all(at(12ms));
    rig.collect();
    EXPECT_EQ(rig.last().status, Status::cancelled);
    EXPECT_GT(rig.engine.earliest_start(UnitId{1}, {3, 4}), at(100ms));
}

}  // namespace transaction_engine_test
}  // namespace takt::bus
