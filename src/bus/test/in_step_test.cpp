// In step: with any delays, no request is given the data of another one; and one exchange suffices to be in
// step again.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "rig.hpp"

namespace takt::bus {
namespace in_step_test {

using namespace test;

constexpr const char* kTwo = "03 00 00 00 02";
constexpr const char* kOthers = "03 00 50 00 02";
constexpr const char* kThree = "03 00 00 00 03";
constexpr const char* kOld = "03 04 11 11 11 11";
constexpr const char* kNew = "03 04 22 22 22 22";
constexpr const char* kOfThree = "03 06 33 33 33 33 33 33";

/// Request 1 has timed out at about 70 ms, and is held until about 120 ms. Units answer within 5 ms.
struct AfterTimeout : Rig {
    AfterTimeout() {
        now = at(10ms);
        ask(1, kTwo);
        run_until(at(75ms));
    }
    void ask(TransactionId id, const char* request) {
        auto asked = transaction(id, 1, request, 50ms);
        asked.longest_delay = 5ms;
        submit(now, asked);
    }
    void answer(Duration t, const char* pdu) {
        run_until(at(t));
        receive(now, rtu(1, pdu));
    }
};

TEST(InStep, AnAnsweredRequestOfAnotherLengthFreesTheUnit) {
    AfterTimeout line;
    line.ask(2, kThree);
    line.answer(95ms, kOfThree);
    ASSERT_EQ(line.last().status, Status::ok) << "nothing can be mistaken for it";
    EXPECT_EQ(line.last().ended_at, at(95ms));
    EXPECT_LT(line.engine.earliest_start(UnitId{1}, {3, 6}), at(100ms)) << "the first one is lost";
}

TEST(InStep, AUnitThatDoesNotAnswerInOrderIsNotFreedByALaterAnswer) {
    AfterTimeout line;
    auto asked = transaction(2, 1, kThree, 50ms);
    asked.in_order = false;
    line.submit(line.now, asked);
    line.answer(95ms, kOfThree);
    ASSERT_EQ(line.last().status, Status::ok);
    EXPECT_GT(line.engine.earliest_start(UnitId{1}, {3, 6}), at(115ms));
}

// Request 1 times out at about 70 ms.
TEST(InStep, AUnitIsSentNothingUntilItsLateResponseUsuallyComes) {
    struct Case {
        Duration patience;  // from the end of the request, at about 14 ms
        Duration earliest;
    };
    for (const auto& c : {Case{0ms, 0ms}, Case{80ms, 90ms}, Case{200ms, 0ms}}) {
        Rig line;
        line.now = at(10ms);
        auto asked = transaction(1, 1, kTwo, 50ms);
        asked.patience = c.patience;
        line.submit(line.now, asked);
        line.run_until(at(75ms));
        ASSERT_EQ(line.last().status, Status::timeout);
        const Instant others = line.engine.earliest_start(UnitId{1}, {3, 8});
        EXPECT_GE(others, at(c.earliest));
        EXPECT_LT(others, at(c.earliest + 80ms)) << "longer than those that look alike wait: not at all";
        EXPECT_LT(line.engine.earliest_start(UnitId{2}, {3, 8}), at(80ms));
        line.receive(line.now, rtu(1, kOld));
        EXPECT_LT(line.engine.earliest_start(UnitId{1}, {3, 8}), at(80ms)) << "it has come";
    }
}

TEST(InStep, ALateResponseThatIsFollowedByTheOwnOneIsDropped) {
    AfterTimeout line;
    line.run_until(at(130ms));
    line.ask(2, kOthers);
    line.answer(140ms, kOld);
    EXPECT_EQ(line.outcomes.size(), 1U);
    line.answer(148ms, kNew);
    ASSERT_EQ(line.outcomes.size(), 2U) << "both were received: nothing more is waited for";
    EXPECT_EQ(line.last().status, Status::ok);
    EXPECT_EQ(line.last().response.registers()[0], 0x2222);
    EXPECT_EQ(line.last().ended_at, at(148ms));
    EXPECT_EQ(line.engine.counters().late_answers, 1U);
    EXPECT_EQ(line.engine.ambiguity(at(150ms), UnitId{1}, {3, 6}), Ambiguity::none);
}

TEST(InStep, AfterTwoResponsesInDoubtTheUnitIsInStepAgain) {
    AfterTimeout line;
    line.run_until(at(130ms));
    line.ask(2, kOthers);
    line.answer(140ms, kOld);
    line.run_until(at(170ms));
    ASSERT_EQ(line.outcomes.size(), 2U);
    EXPECT_EQ(line.last().status, Status::ambiguous);
    EXPECT_TRUE(line.last().response.empty());
    EXPECT_GT(line.engine.earliest_start(UnitId{1}, {3, 6}), at(240ms)) << "twice the time-out";
    line.run_until(at(270ms));
    line.ask(3, kOthers);
    line.answer(280ms, kNew);
    line.run_until(at(310ms));
    ASSERT_EQ(line.outcomes.size(), 3U);
    EXPECT_EQ(line.last().status, Status::ambiguous);
    line.ask(4, kOthers);
    line.answer(320ms, kNew);
    line.run_until(at(350ms));
    ASSERT_EQ(line.outcomes.size(), 4U);
    EXPECT_EQ(line.last().status, Status::ok);
}

// Its end is lost, if the begin was no other one: the next response is confirmed, and not in doubt.
TEST(InStep, AfterAResponseThatIsCutShortTheNextOneIsGood) {
    for (const bool late : {false, true}) {
        LineConfig config = kLine;
        config.echo = Echo::absent;
        Rig line(config);
        const auto ask = [&](TransactionId id, const char* request) {
            auto asked = transaction(id, 1, request, 50ms);
            asked.longest_delay = 5ms;
            line.submit(line.now, asked);
        };
        line.now = at(10ms);
        ask(1, kTwo);
        line.run_until(at(20ms));
        line.receive(at(20ms), "01 03 04 11 11");
        line.run_until(at(90ms));
        ASSERT_EQ(line.outcomes.size(), 1U);
        EXPECT_EQ(line.last().status, Status::bad_checksum);
        EXPECT_LE(line.engine.earliest_start(UnitId{1}, {3, 6}), at(90ms)) << "it is not waited for";
        ask(2, kOthers);
        line.run_until(at(100ms));
        if (late) line.receive(at(100ms), rtu(1, kOld));
        const Instant usual = at(late ? 112ms : 103ms);
        line.run_until(usual);
        line.receive(usual, rtu(1, kNew));
        line.run_until(at(140ms));
        ASSERT_EQ(line.outcomes.size(), 2U) << late;
        EXPECT_EQ(line.last().status, Status::ok) << late;
        EXPECT_EQ(line.last().response.registers()[0], 0x2222) << late;
    }
}

// Every response belongs to the request before.
TEST(InStep, AShiftShowsWhileTheUnitIsHeldAfterAResponseInDoubt) {
    AfterTimeout line;
    line.run_until(at(130ms));
    line.ask(2, kOthers);
    line.answer(140ms, kOld);
    line.answer(170ms, kNew);
    ASSERT_EQ(line.outcomes.size(), 2U);
    EXPECT_EQ(line.last().status, Status::ambiguous);
    EXPECT_TRUE(line.engine.take_late());
    line.ask(3, kTwo);
    line.answer(180ms, kOld);
    ASSERT_EQ(line.outcomes.size(), 3U);
    EXPECT_EQ(line.last().status, Status::ok) << "all responses came";
}

// A response took 5 s once: two in doubt do not prove that the one of request 1 was lost.
TEST(InStep, AResponseStaysInDoubtForTwiceTheLongestDelaySeen) {
    Rig line;
    const auto ask = [&](TransactionId id) {
        auto asked = transaction(id, 1, kTwo, 50ms);
        asked.longest_delay = 5ms;
        asked.lateness = 5s;
        line.submit(line.now, asked);
    };
    line.now = at(10ms);
    ask(1);
    for (TransactionId id = 2; id < 60; ++id) {
        line.run_until(at(id * 200ms));
        ask(id);
        line.run_until(at(id * 200ms + 10ms));
        line.receive(line.now, rtu(1, kNew));
        line.run_until(at(id * 200ms + 60ms));
        ASSERT_EQ(line.outcomes.size(), id);
        if (id * 200ms < 10s) {
            EXPECT_EQ(line.last().status, Status::ambiguous) << id;
        }
    }
    EXPECT_EQ(line.last().status, Status::ok);
}

// Request 1 was lost, as it seems: a later one was answered.
TEST(InStep, OneResponseASecondIsConfirmedWhileAnotherIsRemembered) {
    AfterTimeout line;
    line.ask(2, kThree);
    line.answer(95ms, kOfThree);
    line.run_until(at(5s));
    line.ask(3, kTwo);
    line.answer(5012ms, kOld);
    EXPECT_EQ(line.outcomes.size(), 2U) << "waits for a further frame";
    line.run_until(at(5100ms));
    ASSERT_EQ(line.outcomes.size(), 3U);
    EXPECT_EQ(line.last().status, Status::ok);
    line.ask(4, kTwo);
    line.answer(5112ms, kOld);
    EXPECT_EQ(line.outcomes.size(), 4U) << "within the same second";
    line.run_until(at(7s));
    line.ask(5, kTwo);
    line.answer(7012ms, kOld);
    line.answer(7018ms, kNew);
    line.run_until(at(7100ms));
    ASSERT_EQ(line.outcomes.size(), 5U);
    EXPECT_EQ(line.last().status, Status::ambiguous);
    const auto late = line.engine.take_late();
    ASSERT_TRUE(late);
    EXPECT_TRUE(late->out_of_order_since);
}

// Which of the two came first is not known: neither is published.
TEST(InStep, AResponseOutOfOrderMakesTheOwnOneAmbiguous) {
    AfterTimeout line;
    line.ask(2, kThree);
    line.answer(95ms, kOfThree);
    line.ask(3, kOthers);
    line.answer(110ms, kOld);  // of request 1
    EXPECT_EQ(line.outcomes.size(), 2U);
    line.answer(116ms, kNew);
    line.run_until(at(150ms));
    ASSERT_EQ(line.outcomes.size(), 3U);
    EXPECT_EQ(line.last().status, Status::ambiguous);
    const auto late = line.engine.take_late();
    ASSERT_TRUE(late);
    EXPECT_TRUE(late->out_of_order_since);
    line.ask(4, kOthers);
    line.answer(165ms, kNew);
    EXPECT_EQ(line.last().status, Status::ok);
}

// Without the own response it may have been that one, damaged.
TEST(InStep, AFrameThatDoesNotFitIsALateResponseIfTheOwnOneComesToo) {
    for (const bool own : {false, true}) {
        AfterTimeout line;
        line.ask(2, kThree);
        line.answer(85ms, kOld);
        EXPECT_EQ(line.outcomes.size(), 1U);
        EXPECT_FALSE(line.engine.take_late());
        if (own) line.answer(95ms, kOfThree);
        line.run_until(at(300ms));
        ASSERT_EQ(line.outcomes.size(), 2U);
        EXPECT_EQ(line.last().status, own ? Status::ok : Status::timeout);
        const auto late = line.engine.take_late();
        ASSERT_EQ(late.has_value(), own);
        if (late) {
            EXPECT_EQ(late->at, at(85ms));
        }
    }
}

// A copy of an earlier response and the own one are received together.
TEST(InStep, DifferentResponsesInTheSameBytesAreAmbiguous) {
    for (const bool differ : {false, true}) {
        Rig rig;
        rig.now = at(10ms);
        rig.submit(rig.now, transaction(1, 1, kTwo, 50ms));
        rig.run_until(at(30ms));
        auto bytes = rtu(1, kOld);
        const auto second = rtu(1, differ ? kNew : kOld);
        bytes.insert(bytes.end(), second.begin(), second.end());
        rig.receive(at(30ms), bytes);
        ASSERT_EQ(rig.outcomes.size(), 1U);
        EXPECT_EQ(rig.last().status, differ ? Status::ambiguous : Status::ok);
    }
}

// The unit answers within 5 ms. Long after the failure nothing is confirmed any more, but a response that is
// later than usual may be the one that is missing.
TEST(InStep, AResponseLaterThanUsualIsAmbiguousWhileOneIsMissing) {
    for (const bool missing : {false, true}) {
        AfterTimeout line;
        if (missing) {
            line.ask(2, kThree);
            line.answer(95ms, kOfThree);
        } else {
            line.answer(95ms, kOld);
            EXPECT_TRUE(line.engine.take_late());
        }
        line.run_until(at(5s));
        for (const bool late : {false, true}) {
            const auto before = line.outcomes.size();
            line.ask(3, kOthers);
            line.answer((late ? 6s : 5s) + (late ? 40ms : 12ms), kNew);
            line.run_until(at(late ? 7s : 6s));
            ASSERT_EQ(line.outcomes.size(), before + 1);
            EXPECT_EQ(line.last().status, late && missing ? Status::ambiguous : Status::ok);
        }
    }
}

TEST(InStep, ALinkThatIsLostWhileAResponseIsConfirmedEndsTheTransaction) {
    AfterTimeout line;
    line.run_until(at(130ms));
    line.ask(2, kOthers);
    line.answer(140ms, kOld);
    line.engine.on_link(at(141ms), false);
    line.collect();
    ASSERT_EQ(line.outcomes.size(), 2U);
    EXPECT_EQ(line.last().status, Status::link_lost);
}

}  // namespace in_step_test
}  // namespace takt::bus
