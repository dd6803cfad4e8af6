#include "takt/serve/gateway.hpp"

#include <gtest/gtest.h>

#include "rig.hpp"

namespace takt::serve {
namespace gateway_test {

using namespace test;
using bus::Status;

constexpr auto* kRead = "03 00 00 00 01";
constexpr auto* kOtherRead = "03 00 05 00 01";
constexpr auto* kWrite = "06 00 00 00 07";
constexpr auto* kOne = "03 02 00 01";
constexpr auto* kTwo = "03 02 00 02";

TEST(Gateway, ClientsTakeTurns) {
    Rig rig;
    for (const int address : {1, 2, 3}) rig.ask(1, 9, "06 00 0" + std::to_string(address) + " 00 00");
    rig.ask(2, 9, "06 00 0A 00 00");
    rig.ask(3, 9, "06 00 0B 00 00");
    std::string order;
    while (!rig.begin().empty()) {
        order += hex(rig.sent->request.pdu()).substr(6, 2) + " ";
        rig.end(Status::ok, hex(rig.sent->request.pdu()));
    }
    EXPECT_EQ(order, "01 0A 0B 02 03 ");
    EXPECT_EQ(rig.answers.size(), 5u);
}

TEST(Gateway, PeersTakeTurnsHoweverManyConnectionsTheyHave) {
    Rig rig;
    rig.peer = 1;
    std::vector<serve::Token> flood;
    for (std::uint64_t client = 0; client < 60; ++client)
        flood.push_back(rig.ask(client, 1, "03 00 00 00 01"));
    rig.peer = 2;
    int served = 0;
    for (int round = 0; round < 40; ++round) {
        const auto token = rig.ask(100, 2, "03 00 00 00 01");
        for (int transactions = 0; rig.answer(token).empty(); ++transactions) {
            ASSERT_LT(transactions, 2) << "one of the other peer at most goes first";
            ASSERT_FALSE(rig.begin().empty());
            rig.end(bus::Status::exception, "83 02");
            ++served;
        }
        // The greedy peer asks again and again with all its connections; equal reads would be shared.
        rig.peer = 1;
        (void)rig.ask(static_cast<std::uint64_t>(round % 60), 1,
                      "03 00 " + std::to_string(10 + round) + " 00 01");
        rig.peer = 2;
    }
    EXPECT_GE(served, 60) << "the greedy peer gets its share as well";
}

TEST(Gateway, NoReadOvertakesAWriteOfAnotherPeer) {
    Rig rig;
    rig.peer = 1;
    (void)rig.ask(1, 1, "06 00 00 00 01");
    (void)rig.ask(2, 1, "06 00 00 00 02");
    rig.peer = 2;
    (void)rig.ask(3, 1, "03 00 00 00 01");
    (void)rig.ask(4, 2, "03 00 00 00 01");
    std::vector<std::string> sent;
    while (!rig.sent) {
        const auto text = rig.begin();
        if (text.empty()) break;
        sent.push_back(text.substr(0, 5));
        rig.end(bus::Status::exception, text[3] == '0' && text[4] == '6' ? "86 04" : "83 04");
    }
    EXPECT_EQ(sent, (std::vector<std::string>{"1: 06", "1: 06", "1: 03", "2: 03"}));
}

TEST(Gateway, AFullQueueTakesFromThePeerWithMost) {
    GatewayConfig config;
    config.requests = 8;
    Rig rig(config);
    rig.peer = 1;
    std::vector<serve::Token> greedy;
    for (std::uint64_t client = 0; client < 8; ++client)
        greedy.push_back(rig.ask(client, 1, "06 00 00 00 01"));
    EXPECT_EQ(rig.answer(rig.ask(50, 1, "06 00 00 00 01")), "86 06") << "of the same peer";
    rig.peer = 2;
    const auto other = rig.ask(100, 1, "06 00 00 00 02");
    EXPECT_EQ(rig.answer(other), "");
    EXPECT_EQ(rig.answer(greedy.back()), "86 06");
    EXPECT_EQ(rig.gateway.waiting(), 8u);
}

TEST(Gateway, ReportsWhetherTheLineCanGoOn) {
    Rig rig;
    EXPECT_FALSE(rig.gateway.has_next());
    rig.ask(1, 9, kRead);
    rig.ask(1, 9, kOtherRead);
    EXPECT_TRUE(rig.gateway.has_next());
    rig.begin();
    EXPECT_FALSE(rig.gateway.has_next()) << "one is under way";
    rig.end(Status::ok, kOne);
    EXPECT_TRUE(rig.gateway.has_next()) << "the next of that client";
    rig.gateway.on_link(false);
    EXPECT_FALSE(rig.gateway.has_next());
}

TEST(Gateway, EqualReadsAreAnsweredTogether) {
    Rig rig;
    const auto first = rig.ask(1, 9, kRead);
    const auto waiting = rig.ask(2, 9, kRead);
    EXPECT_EQ(rig.begin(), "9: 03 00 00 00 01");
    const auto joining = rig.ask(3, 9, kRead);
    const auto other_unit = rig.ask(4, 8, kRead);
    const auto other_place = rig.ask(5, 9, kOtherRead);
    EXPECT_EQ(rig.answer(first), "");
    rig.end(Status::ok, kOne);
    for (const auto token : {first, waiting, joining}) EXPECT_EQ(rig.answer(token), kOne);
    for (const auto token : {other_unit, other_place}) EXPECT_EQ(rig.answer(token), "");
    EXPECT_EQ(rig.gateway.counters().shared, 2u);
    EXPECT_EQ(rig.gateway.counters().sent, 1u);
}

TEST(Gateway, ExceptionsAreSharedToo) {
    Rig rig;
    const auto first = rig.ask(1, 9, kRead);
    const auto second = rig.ask(2, 9, kRead);
    rig.begin();
    rig.end(Status::exception, "83 02");
    EXPECT_EQ(rig.answer(first), "83 02");
    EXPECT_EQ(rig.answer(second), "83 02");
}

TEST(Gateway, WritesAreNeverShared) {
    Rig rig;
    rig.ask(1, 9, kWrite);
    rig.ask(2, 9, kWrite);
    rig.begin();
    rig.end(Status::ok, kWrite);
    EXPECT_EQ(rig.answers.size(), 1u);
    EXPECT_EQ(rig.begin(), "9: 06 00 00 00 07");
}

TEST(Gateway, AReadAfterAWriteIsNotAnsweredFromBeforeIt) {
    Rig rig;
    const auto before = rig.ask(1, 9, kRead);
    rig.begin();
    const auto write = rig.ask(2, 9, kWrite);
    const auto later = rig.ask(3, 9, kRead);
    rig.end(Status::ok, kOne);
    EXPECT_EQ(rig.answer(before), kOne);
    EXPECT_EQ(rig.answer(later), "");
    EXPECT_EQ(rig.begin(), "9: 06 00 00 00 07");
    rig.end(Status::ok, kWrite);
    EXPECT_EQ(rig.answer(write), kWrite);
    EXPECT_EQ(rig.begin(), "9: 03 00 00 00 01");
    rig.end(Status::ok, kTwo);
    EXPECT_EQ(rig.answer(later), kTwo);
}

TEST(Gateway, TheCacheAnswersForAsLongAsTheServerWants) {
    Rig rig;
    rig.policy.cache = 200ms;
    rig.ask(1, 9, kRead);
    rig.begin();
    rig.end(Status::ok, kOne);
    rig.now += 200ms;
    EXPECT_EQ(rig.answer(rig.ask(2, 9, kRead)), kOne);
    EXPECT_EQ(rig.answer(rig.ask(2, 8, kRead)), "");
    EXPECT_EQ(rig.answer(rig.ask(3, 9, kOtherRead)), "");
    rig.now += 1ms;
    EXPECT_EQ(rig.answer(rig.ask(4, 9, kRead)), "");
    EXPECT_EQ(rig.gateway.counters().from_cache, 1u);
}

TEST(Gateway, WithoutACacheNothingIsKept) {
    Rig rig;
    rig.ask(1, 9, kRead);
    rig.begin();
    rig.end(Status::ok, kOne);
    EXPECT_EQ(rig.answer(rig.ask(2, 9, kRead)), "");
}

TEST(Gateway, AWriteDropsWhatIsCachedOfItsUnit) {
    for (const int written : {9, 0, 8}) {
        Rig rig;
        rig.policy.cache = 1s;
        rig.ask(1, 9, kRead);
        rig.begin();
        rig.end(Status::ok, kOne);
        rig.ask(2, static_cast<std::uint8_t>(written), kWrite);
        EXPECT_EQ(rig.answer(rig.ask(3, 9, kRead)), written == 8 ? kOne : "") << written;
    }
}

TEST(Gateway, WhatWasReadBeforeAWriteIsNotCachedAfterIt) {
    Rig rig;
    rig.policy.cache = 1s;
    rig.ask(1, 9, kRead);
    rig.begin();
    rig.ask(2, 9, kWrite);
    rig.end(Status::ok, kOne);
    EXPECT_EQ(rig.answer(rig.ask(3, 9, kRead)), "");
}

TEST(Gateway, SaysWhatBecameOfATransaction) {
    struct Row {
        const char* request;
        Status status;
        bool sent;
        const char* answer;
    };
    const Row rows[] = {
        {kRead, Status::timeout, true, "83 0B"},      {kWrite, Status::timeout, true, "86 0B"},
        {kRead, Status::bad_checksum, true, "83 0B"}, {kWrite, Status::unexpected_reply, true, "86 0B"},
        {kRead, Status::link_lost, false, "83 0A"},   {kWrite, Status::link_lost, false, "86 0A"},
        {kWrite, Status::link_lost, true, "86 0B"},   {kRead, Status::line_busy, false, "83 0A"},
        {kWrite, Status::cancelled, true, "86 0B"},
    };
    for (const auto& [request, status, sent, expected] : rows) {
        Rig rig;
        const auto token = rig.ask(1, 9, request);
        rig.begin();
        rig.end(status, {}, sent);
        EXPECT_EQ(rig.answer(token), expected) << request << " " << bus::name(status) << " " << sent;
        EXPECT_EQ(rig.fates.at(token), sent ? Fate::unknown : Fate::not_sent);
    }
    Rig rig;
    rig.policy.max_wait = 10ms;
    const auto answered = rig.ask(1, 9, kWrite);
    rig.begin();
    const auto late = rig.ask(2, 9, kWrite);
    rig.now += 20ms;
    rig.gateway.on_tick(rig.now);
    rig.end(Status::exception, "86 02");
    EXPECT_EQ(rig.fates.at(answered), Fate::answered);
    EXPECT_EQ(rig.fates.at(late), Fate::not_sent);
}

TEST(Gateway, ARequestThatWasNotSentCanBeRefused) {
    Rig rig;
    const auto sent = rig.ask(1, 9, kRead);
    const auto next = rig.ask(1, 9, kWrite);
    rig.begin();
    const auto joined = rig.ask(2, 9, kRead);
    EXPECT_FALSE(rig.gateway.refuse(1, sent, wire::ExceptionCode::illegal_function));
    EXPECT_TRUE(rig.gateway.is_in_flight(1, sent));
    EXPECT_FALSE(rig.gateway.is_in_flight(1, joined)) << "it shares the transaction of another";
    EXPECT_TRUE(rig.gateway.refuse(1, joined, wire::ExceptionCode::illegal_function));
    EXPECT_TRUE(rig.gateway.refuse(1, next, wire::ExceptionCode::illegal_function));
    EXPECT_FALSE(rig.gateway.refuse(1, next, wire::ExceptionCode::illegal_function)) << "once";
    rig.collect();
    EXPECT_EQ(rig.answer(joined), "83 01");
    EXPECT_EQ(rig.fates.at(next), Fate::not_sent);
    rig.end(Status::ok, kOne);
    EXPECT_EQ(rig.answer(sent), kOne);
    EXPECT_EQ(rig.begin(), "");
}

TEST(Gateway, AWithdrawnTransactionWaitsAgain) {
    Rig rig;
    const auto write = rig.ask(1, 9, kWrite);
    const auto read = rig.ask(2, 9, kRead);
    EXPECT_EQ(rig.begin(), "9: 06 00 00 00 07");
    rig.gateway.on_withdrawn();
    rig.gateway.on_withdrawn();
    EXPECT_EQ(rig.gateway.counters().sent, 0u);
    EXPECT_EQ(rig.begin(), "9: 06 00 00 00 07");
    rig.gateway.on_withdrawn();
    EXPECT_EQ(rig.gateway.forget(1, write), Fate::not_sent);
    EXPECT_EQ(rig.gateway.forget(1, write), std::nullopt);
    EXPECT_EQ(rig.begin(), "9: 03 00 00 00 01");
    EXPECT_EQ(rig.gateway.forget(1, read), Fate::unknown);
}

// The line holds back reads of one register of unit 9.
TEST(Gateway, ARequestThatTheLineHoldsBackLetsOthersPass) {
    Rig rig;
    const auto may_start = [](UnitId unit, const bus::AnswerShape& shape) {
        return unit != UnitId{9} || shape != bus::AnswerShape{3, 4};
    };
    const auto next = [&] {
        rig.sent = rig.gateway.next(rig.now, may_start);
        return rig.sent ? rig.sent->unit.value : 0;
    };
    rig.ask(1, 9, kRead);
    EXPECT_EQ(next(), 9) << "all are held back: it waits on the line";
    EXPECT_FALSE(rig.gateway.should_withdraw(may_start));
    rig.ask(2, 9, kRead);
    EXPECT_FALSE(rig.gateway.should_withdraw(may_start)) << "the same request";
    rig.ask(3, 8, kRead);
    EXPECT_TRUE(rig.gateway.should_withdraw(may_start));
    rig.gateway.on_withdrawn();
    EXPECT_EQ(next(), 8);
    EXPECT_FALSE(rig.gateway.should_withdraw(may_start));
    rig.end(Status::ok, "03 02 00 07");
    rig.ask(3, 8, kRead);
    EXPECT_EQ(rig.begin(), "9: 03 00 00 00 01") << "once it is free, it is the first";
    rig.end(Status::ok, "03 02 00 07");
    EXPECT_EQ(next(), 8);
}

TEST(Gateway, AReadDoesNotPassAWriteThatTheLineHoldsBack) {
    Rig rig;
    const auto may_start = [](UnitId, const bus::AnswerShape& shape) { return shape.function == 3; };
    rig.ask(1, 9, kWrite);
    rig.ask(2, 9, kRead);
    rig.sent = rig.gateway.next(rig.now, may_start);
    ASSERT_TRUE(rig.sent);
    EXPECT_EQ(rig.sent->request.function(), 6);
    EXPECT_FALSE(rig.gateway.should_withdraw(may_start));
}

/// Three transactions of the unit without a response.
void let_die(Rig& rig, std::uint8_t unit) {
    for (int i = 0; i < 3; ++i) {
        rig.ask(1, unit, kWrite);
        ASSERT_NE(rig.begin(), "") << i;
        rig.end(Status::timeout);
    }
}

TEST(Gateway, AUnitThatDoesNotAnswerIsAskedOnceInEachBackOff) {
    Rig rig;
    let_die(rig, 9);
    Duration wait = 1s;
    for (int probes = 0; probes < 8; ++probes) {
        rig.now += wait - 1ms;
        EXPECT_EQ(rig.answer(rig.ask(2, 9, kRead)), "83 0B") << "not before " << wait.count();
        EXPECT_EQ(rig.begin(), "");
        rig.now += 1ms;
        const auto probe = rig.ask(2, 9, kRead);
        EXPECT_EQ(rig.answer(rig.ask(3, 9, kRead)), "83 0B") << "one is enough";
        EXPECT_EQ(rig.begin(), "9: 03 00 00 00 01");
        EXPECT_EQ(rig.answer(rig.ask(3, 9, kWrite)), "86 0B");
        rig.end(Status::timeout);
        EXPECT_EQ(rig.answer(probe), "83 0B");
        wait = std::min<Duration>(2 * wait, 60s);
    }
    EXPECT_EQ(rig.gateway.counters().sent, 3u + 8);
    EXPECT_EQ(rig.gateway.counters().not_asked, 8u * 3);
    EXPECT_EQ(rig.gateway.counters().no_answer, 3u + 8 + 24);
    EXPECT_EQ(rig.answered_twice, 0);
}

TEST(Gateway, AnAnswerEndsTheBackOff) {
    for (const Status status : {Status::ok, Status::exception}) {
        Rig rig;
        let_die(rig, 9);
        rig.now += 1s;
        rig.ask(1, 9, kRead);
        rig.begin();
        rig.end(status, status == Status::ok ? kOne : "83 02");
        for (std::uint64_t client = 1; client <= 2; ++client)
            EXPECT_EQ(rig.answer(rig.ask(client, 9, kWrite)), "") << "sent again";
    }
}

// A unit that keeps silent about some registers is no dead unit.
TEST(Gateway, ABackOffConcernsThePeerThatIsNotAnswered) {
    Rig rig;
    rig.peer = 1;
    let_die(rig, 9);
    EXPECT_EQ(rig.answer(rig.ask(1, 9, kRead)), "83 0B");
    for (int i = 0; i < 100; ++i) {
        rig.peer = 1;
        (void)rig.ask(1, 9, "03 03 E8 00 01");
        (void)rig.ask(2, 9, "03 03 E8 00 01");
        rig.peer = 2;
        const auto fair = rig.ask(3, 9, kRead);
        for (std::string next = rig.begin(); !next.empty(); next = rig.begin())
            next.ends_with("00 00 00 01") ? rig.end(Status::ok, kOne) : rig.end(Status::timeout);
        EXPECT_EQ(rig.answer(fair), kOne) << i;
        rig.now += 1s;
    }
    EXPECT_LT(rig.gateway.counters().sent, 100u + 3 + 8) << "the probes of the other peer";
}

TEST(Gateway, ABackOffConcernsItsUnitOnlyAndEndsWithTheConnection) {
    Rig rig;
    let_die(rig, 9);
    EXPECT_EQ(rig.answer(rig.ask(1, 8, kWrite)), "");
    EXPECT_EQ(rig.begin(), "8: 06 00 00 00 07");
    rig.end(Status::ok, kWrite);
    rig.gateway.on_link(false);
    rig.gateway.on_link(true);
    EXPECT_EQ(rig.answer(rig.ask(1, 9, kWrite)), "");
}

TEST(Gateway, WhatWaitsForADeadUnitIsAnsweredWithTheLastFailure) {
    Rig rig;
    rig.policy.attempts = 5;
    std::vector<serve::Token> tokens;
    for (std::uint64_t client = 1; client <= 3; ++client)
        for (const char* request : {kRead, kWrite}) tokens.push_back(rig.ask(client, 9, request));
    const auto other = rig.ask(4, 8, kWrite);
    int transactions = 0;
    for (std::string next = rig.begin(); !next.empty(); next = rig.begin(), ++transactions)
        rig.end(next.starts_with("9") ? Status::timeout : Status::ok, next.starts_with("9") ? "" : kWrite);
    EXPECT_LE(transactions, 4);
    for (const auto token : tokens) EXPECT_NE(rig.answer(token), "");
    EXPECT_EQ(rig.answer(other), kWrite);
    EXPECT_EQ(rig.gateway.waiting(), 0u);
}

TEST(Gateway, TheExceptionsOfAnotherGatewayCountAsNoAnswer) {
    Rig rig;
    for (int i = 0; i < 3; ++i) {
        const auto token = rig.ask(1, 9, kRead);
        rig.begin();
        rig.end(Status::exception, "83 0B");
        EXPECT_EQ(rig.answer(token), "83 0B");
    }
    EXPECT_EQ(rig.answer(rig.ask(1, 9, kRead)), "83 0B");
    EXPECT_EQ(rig.gateway.counters().not_asked, 1u);
}

// Polling knows that the device does not answer. It ends that knowledge itself.
TEST(Gateway, ATimeOutWithoutSendingIsNoFailureOfTheUnit) {
    Rig rig;
    rig.policy.attempts = 3;
    for (int i = 0; i < 5; ++i) {
        const auto token = rig.ask(1, 9, kRead);
        EXPECT_NE(rig.begin(), "") << i;
        rig.end(Status::timeout, {}, false);
        EXPECT_EQ(rig.answer(token), "83 0B");
        EXPECT_EQ(rig.begin(), "");
    }
    EXPECT_EQ(rig.gateway.counters().sent, 0u);
    EXPECT_EQ(rig.gateway.counters().not_asked, 5u);
}

TEST(Gateway, ReadsAreTriedAgainBehindTheOthers) {
    Rig rig;
    rig.policy.attempts = 2;
    const auto first = rig.ask(1, 9, kRead);
    const auto joined = rig.ask(2, 9, kRead);
    const auto other = rig.ask(3, 8, kRead);
    rig.begin();
    rig.end(Status::timeout);
    EXPECT_EQ(rig.answer(first), "");
    EXPECT_EQ(rig.begin(), "8: 03 00 00 00 01");
    rig.end(Status::ok, kOne);
    EXPECT_EQ(rig.answer(other), kOne);
    EXPECT_EQ(rig.begin(), "9: 03 00 00 00 01");
    rig.end(Status::timeout);
    EXPECT_EQ(rig.answer(first), "83 0B");
    EXPECT_EQ(rig.answer(joined), "83 0B");
    EXPECT_EQ(rig.begin(), "");
}

TEST(Gateway, WritesAreNeverTriedAgain) {
    Rig rig;
    rig.policy.attempts = 5;
    const auto write = rig.ask(1, 9, kWrite);
    rig.begin();
    rig.end(Status::timeout);
    EXPECT_EQ(rig.answer(write), "86 0B");
    EXPECT_EQ(rig.begin(), "");
}

TEST(Gateway, WithoutItsLineThereIsNoPath) {
    Rig rig;
    const auto sent = rig.ask(1, 9, kWrite);
    const auto waiting = rig.ask(2, 9, kRead);
    const auto behind = rig.ask(2, 9, kOtherRead);
    rig.begin();
    rig.gateway.on_link(false);
    rig.collect();
    EXPECT_EQ(rig.answer(sent), "");
    EXPECT_EQ(rig.answer(waiting), "83 0A");
    EXPECT_EQ(rig.answer(behind), "83 0A");
    EXPECT_EQ(rig.answer(rig.ask(3, 9, kRead)), "83 0A");
    rig.end(Status::link_lost);
    EXPECT_EQ(rig.answer(sent), "86 0B");
    EXPECT_EQ(rig.begin(), "");
    rig.gateway.on_link(true);
    rig.ask(1, 9, kRead);
    EXPECT_EQ(rig.begin(), "9: 03 00 00 00 01");
}

TEST(Gateway, IsBusyWhenThereIsNoRoom) {
    Rig rig({.requests = 3, .per_client = 2});
    rig.ask(1, 9, kWrite);
    rig.ask(1, 9, kWrite);
    EXPECT_EQ(rig.answer(rig.ask(1, 9, kRead)), "83 06");
    rig.ask(2, 9, kRead);
    EXPECT_EQ(rig.answer(rig.ask(3, 9, kOtherRead)), "83 06");
    EXPECT_EQ(rig.gateway.waiting(), 3u);
    rig.begin();
    rig.end(Status::ok, kWrite);
    EXPECT_EQ(rig.answer(rig.ask(3, 9, kOtherRead)), "");
}

TEST(Gateway, WhatWaitsTooLongIsNotSent) {
    Rig rig;
    rig.policy.max_wait = 100ms;
    const auto sent = rig.ask(1, 9, kWrite);
    const auto waiting = rig.ask(2, 9, kWrite);
    rig.begin();
    EXPECT_EQ(rig.gateway.next_wakeup(), rig.now + 100ms);
    rig.now += 99ms;
    rig.gateway.on_tick(rig.now);
    rig.collect();
    EXPECT_EQ(rig.answer(waiting), "");
    rig.now += 1ms;
    rig.gateway.on_tick(rig.now);
    rig.collect();
    EXPECT_EQ(rig.answer(waiting), "86 06");
    EXPECT_EQ(rig.gateway.next_wakeup(), kNever);
    rig.end(Status::ok, kWrite);
    EXPECT_EQ(rig.answer(sent), kWrite);
    EXPECT_EQ(rig.begin(), "");
}

TEST(Gateway, WhoWentAwayIsForgotten) {
    Rig rig;
    const auto sent = rig.ask(1, 9, kWrite);
    const auto waiting = rig.ask(2, 9, kWrite);
    const auto third = rig.ask(3, 9, kRead);
    rig.begin();
    rig.gateway.forget(1, sent);
    rig.gateway.forget(1, waiting);
    rig.gateway.forget(2, third);
    EXPECT_EQ(rig.gateway.waiting(), 1u);
    EXPECT_TRUE(rig.gateway.under_way());
    EXPECT_EQ(rig.begin(), "") << "the transaction is finished first";
}

TEST(Gateway, TheAnswerToADisconnectedClientReachesNoOther) {
    Rig rig;
    const auto gone = rig.ask(1, 9, kWrite);
    rig.begin();
    rig.gateway.forget(1, gone);
    const auto next = rig.ask(1, 9, kOtherRead);
    rig.end(Status::ok, kWrite);
    EXPECT_TRUE(rig.answers.empty());
    EXPECT_EQ(rig.begin(), "9: 03 00 05 00 01");
    rig.end(Status::ok, kTwo);
    EXPECT_EQ(rig.answer(next), kTwo);
}

TEST(Gateway, WhatMustNotBePassedOnIsRefused) {
    const std::pair<const char*, const char*> rows[] = {
        {"00", "80 01"},
        {"83 00 00", "83 01"},
        {"03 00 00 00 01 C4 0B 09 06 00 00 00 07", "83 03"},  // a second frame behind the first
        {"03 00 00 00", "83 03"},
        {"03 00 00 00 7E", "83 03"},
        {"10 00 00 00 02 02 00 01", "90 03"},
        {"06 00 00 00 01 00", "86 03"},
    };
    for (const auto& [request, expected] : rows) {
        Rig rig;
        EXPECT_EQ(rig.answer(rig.ask(1, 9, request)), expected) << request;
    }
    Rig rig;
    EXPECT_EQ(rig.answer(rig.ask(1, 9, "41 01 02")), "") << "a function of the device's own";
}

TEST(Gateway, BroadcastsAreWritesAndAnsweredWhenTheyAreSent) {
    Rig rig;
    EXPECT_EQ(rig.answer(rig.ask(1, 0, kRead)), "83 01");
    const auto single = rig.ask(1, 0, kWrite);
    EXPECT_EQ(rig.begin(), "0: 06 00 00 00 07");
    rig.end(Status::ok);
    EXPECT_EQ(rig.answer(single), kWrite);
    const auto many = rig.ask(1, 0, "10 00 01 00 02 04 00 01 00 02");
    rig.begin();
    rig.end(Status::ok);
    EXPECT_EQ(rig.answer(many), "10 00 01 00 02");
    Rig numbered({.broadcast = false});
    EXPECT_EQ(numbered.answer(numbered.ask(1, 0, kRead)), "");
}

TEST(Gateway, AnotherTransactionsOutcomeAnswersNoClient) {
    Rig rig;
    const auto token = rig.ask(1, 9, kRead);
    rig.begin();
    rig.gateway.on_outcome({.id = rig.sent->id + 1, .response = wire::ResponseView(pdu(kTwo).span())});
    rig.collect();
    EXPECT_EQ(rig.answer(token), "");
    rig.end(Status::ok, kOne);
    EXPECT_EQ(rig.answer(token), kOne);
}

}  // namespace gateway_test
}  // namespace takt::serve
