// What the judge takes for indistinguishable, and what it does not (judge/ledger.hpp).
#include "judge/ledger.hpp"

#include <gtest/gtest.h>

namespace takt::judge {
namespace ledger_test {

using namespace std::chrono_literals;

ByteVector framed(ByteVector bytes) {
    const auto check = crc(bytes);
    bytes.push_back(static_cast<std::uint8_t>(check));
    bytes.push_back(static_cast<std::uint8_t>(check >> 8U));
    return bytes;
}

/// Unit 5 with reads of one and of two registers, and a write.
struct Line {
    AnswerLedger ledger{wire::Framing::rtu};
    Asked last;
    Instant sent;
    Instant now;

    static constexpr Instant at(Duration since) { return Instant{} + since; }
    void ask(Duration when, ByteVector pdu) {
        pdu.insert(pdu.begin(), 5);
        last = parse_request(wire::Framing::rtu, framed(pdu)).value();
        now = sent = at(when);
        ledger.on_sent(sent, last);
    }
    void read(Duration when, std::uint8_t start, std::uint8_t count = 1) {
        ask(when, {3, 0, start, 0, count});
    }
    void hear(Duration when, ByteVector pdu) {
        pdu.insert(pdu.begin(), 5);
        now = at(when);
        ledger.on_heard(now, framed(pdu));
    }
    void one(Duration when, std::uint8_t value) { hear(when, {3, 2, 0, value}); }
    void two(Duration when) { hear(when, {3, 4, 0, 1, 0, 2}); }
    [[nodiscard]] std::string exempt(std::uint8_t value) const {
        return std::string(ledger.exemption(now, sent, last, {3, 2, 0, value}).value_or(""));
    }
    /// A read that is answered as usual.
    void exchange(Duration when, std::uint8_t value) {
        read(when, 0);
        one(when + 10ms, value);
    }
};

TEST(Ledger, ARequestOfAnotherShapeMayCheckAUnitThatWasAskedForOne) {
    Line line;
    for (Duration t{}; t < 180ms; t += 20ms) line.exchange(t, 7);
    line.read(190ms, 0, 2);
    EXPECT_FALSE(line.ledger.may_check(line.sent, 5)) << "too early";
    line.two(195ms);
    for (Duration t = 200ms; t < 400ms; t += 20ms) line.exchange(t, 7);
    EXPECT_FALSE(line.ledger.may_check(line.sent, 5)) << "the same shape";
    line.read(400ms, 0, 2);
    EXPECT_TRUE(line.ledger.may_check(line.sent, 5));
    EXPECT_FALSE(line.ledger.may_check(line.sent, 6));
}

TEST(Ledger, AfterASurplusAnswerAUnitMayBeCheckedForMinutes) {
    Line line;
    line.exchange(0ms, 7);
    line.one(15ms, 7);
    line.exchange(20ms, 7);
    line.read(40ms, 0, 2);
    EXPECT_TRUE(line.ledger.may_check(line.sent, 5));
    EXPECT_FALSE(line.ledger.may_check(line.sent, 6));
    line.two(45ms);
    for (Duration t = 6min; t < 6min + 180ms; t += 20ms) line.exchange(t, 7);
    line.read(6min + 190ms, 0, 2);
    EXPECT_FALSE(line.ledger.may_check(line.sent, 5)) << "forgotten";
}

TEST(Ledger, AnAnswerOfAnUnknownFunctionIsASurplusOne) {
    Line line;
    line.exchange(0ms, 7);
    line.read(20ms, 0);
    line.hear(30ms, {0x22, 1, 0});
    line.read(40ms, 0, 2);
    EXPECT_TRUE(line.ledger.may_check(line.sent, 5));
}

// Both were received: the damaged exception may be the answer, and the read is sent again at once.
TEST(Ledger, ADamagedExceptionMayBeTheAnswer) {
    Line line;
    line.exchange(0ms, 7);
    line.read(20ms, 1);
    line.now = line.at(30ms);
    line.ledger.on_heard(line.now, ByteVector{5, 0x83, 2, 0, 7, 0x12});
    line.read(50ms, 1);
    line.one(60ms, 7);
    EXPECT_NE(line.exempt(7), "") << "a copy of the answer before";
}

TEST(Ledger, ALateAnswerWhileItsRequestIsOwedIsNoExcuse) {
    Line line;
    line.read(0ms, 0);
    line.read(200ms, 1);
    line.one(210ms, 7);
    EXPECT_EQ(line.exempt(7), "");
    EXPECT_TRUE(line.ledger.doubtful(line.last));
}

TEST(Ledger, AfterAsManyAnswersAsRequestsTheLastOneBelongsToTheLastRequest) {
    Line line;
    line.read(0ms, 0);
    line.read(200ms, 1);
    line.one(210ms, 7);
    line.one(220ms, 8);
    EXPECT_EQ(line.exempt(7), "");
    EXPECT_EQ(line.exempt(8), "exempt_reordered");
}

TEST(Ledger, ACopyWhereNothingIsOwedCannotBeRecognised) {
    Line line;
    line.exchange(0ms, 7);
    line.read(100ms, 1);
    line.one(105ms, 7);
    EXPECT_EQ(line.exempt(7), "exempt_copy");
    EXPECT_EQ(line.exempt(9), "") << "no frame holds this value";
}

TEST(Ledger, AnAnswerOfAnotherShapePassesWhatWasOwed) {
    Line line;
    line.read(0ms, 0);
    line.read(200ms, 1, 2);
    line.two(210ms);
    line.read(300ms, 1);
    line.one(310ms, 7);
    EXPECT_EQ(line.exempt(7), "exempt_passed");
}

// Until its usual lateness has passed; with fewer than three late answers, for eight usual delays.
TEST(Ledger, NotOfAUnitThatHasAnsweredOutOfOrderForAWhile) {
    for (const bool soon : {true, false}) {
        Line line;
        line.read(0ms, 0);
        line.read(200ms, 1, 2);
        line.two(210ms);
        line.one(250ms, 7);
        line.read(300ms, 0);
        line.read(330ms, 1, 2);
        line.two(340ms);
        const auto next = soon ? 350ms : 600ms;
        line.read(next, 1);
        line.one(next + 10ms, 7);
        EXPECT_EQ(line.exempt(7), soon ? "" : "exempt_passed");
    }
}

TEST(Ledger, TwoAnswersThatNothingFollowedPassWhatWasOwed) {
    Line line;
    line.exchange(0ms, 1);
    line.read(100ms, 0);
    line.exchange(300ms, 2);
    line.exchange(400ms, 3);
    line.read(500ms, 1);
    line.one(505ms, 7);
    EXPECT_EQ(line.exempt(7), "exempt_passed");
}

TEST(Ledger, NotWhereTheNextRequestWasSentBeforeAFurtherOneCouldCome) {
    Line line;
    line.exchange(0ms, 1);
    line.read(100ms, 0);
    for (int i = 0; i < 5; ++i) line.exchange(300ms + i * 12ms, 2);
    line.read(362ms, 1);
    line.one(365ms, 7);
    EXPECT_EQ(line.exempt(7), "") << "each answer may belong to the request before";
}

TEST(Ledger, AnExceptionOfSeveralOpenRequestsSettlesNone) {
    Line line;
    line.read(0ms, 0);
    line.read(200ms, 0, 2);
    line.hear(210ms, {0x83, 2});
    line.read(300ms, 1);
    line.one(310ms, 7);
    EXPECT_EQ(line.exempt(7), "");
}

TEST(Ledger, AWriteIsConfirmedFalselyByTheCopyOfAConfirmation) {
    Line line;
    const ByteVector confirmation{16, 0, 40, 0, 1};
    line.ask(0ms, {16, 0, 40, 0, 1, 2, 0, 9});
    line.hear(10ms, confirmation);
    line.ask(100ms, {16, 0, 40, 0, 1, 2, 0, 8});
    line.hear(105ms, confirmation);
    EXPECT_EQ(line.ledger.exemption(line.now, line.sent, line.last, confirmation), "exempt_copy");
    line.ask(200ms, {16, 0, 40, 0, 1, 2, 0, 7});
    line.ask(400ms, {16, 0, 40, 0, 1, 2, 0, 6});
    line.hear(405ms, confirmation);
    EXPECT_FALSE(line.ledger.exemption(line.now, line.sent, line.last, confirmation));
}

TEST(Ledger, FramesAreFoundInPiecesAndBetweenOtherBytes) {
    Line line;
    line.read(0ms, 0);
    ByteVector bytes{0x00, 0xFF, 0x05};
    for (const auto byte : framed({5, 3, 2, 0, 7})) bytes.push_back(byte);
    bytes.push_back(0x00);
    for (const auto byte : bytes) line.ledger.on_heard(Line::at(10ms), std::span(&byte, 1));
    ASSERT_EQ(line.ledger.candidates(line.last).size(), 1U);
    EXPECT_EQ(line.ledger.candidates(line.last)[0], (ByteVector{3, 2, 0, 7}));
}

TEST(Ledger, ANewConnectionOwesNothing) {
    Line line;
    line.read(0ms, 0);
    line.ledger.on_connection(line.now);
    line.read(200ms, 1);
    EXPECT_FALSE(line.ledger.doubtful(line.last));
}

TEST(Ledger, BytesThatBeginLikeTheAnswerAndAreAsManyHaveComeDespiteTheirChecksum) {
    for (const bool whole : {true, false}) {
        Line line;
        line.read(0ms, 0);
        ByteVector damaged = framed({5, 3, 2, 0, 9});
        damaged.back() ^= 1U;
        if (!whole) damaged.erase(damaged.begin() + 3);
        line.ledger.on_heard(Line::at(10ms), damaged);
        line.read(200ms, 1);
        line.one(210ms, 7);
        EXPECT_EQ(line.exempt(7), whole ? "exempt_passed" : "");
    }
}

TEST(Ledger, OfTwoRequestsTheOneThatIsNotAnsweredWasRefused) {
    Line line;
    line.read(0ms, 0);
    line.read(200ms, 1, 2);
    line.hear(210ms, {0x83, 2});
    line.read(300ms, 0);
    EXPECT_TRUE(line.ledger.doubtful(line.last)) << "which one is not known";
    line.one(310ms, 7);
    line.one(320ms, 8);
    line.read(400ms, 1, 2);
    EXPECT_FALSE(line.ledger.doubtful(line.last)) << "the first one was answered";
}

TEST(Ledger, AFunctionIsInDoubtWhileTheMasterMayExpectAnAnswer) {
    Line line;
    line.exchange(0ms, 1);
    line.read(100ms, 0);
    const AnswerLedger::Shape reads{.unit = 5, .function = 3};
    EXPECT_FALSE(line.ledger.in_doubt(line.now, reads)) << "it may still be answered";
    line.exchange(300ms, 2);
    EXPECT_TRUE(line.ledger.in_doubt(line.now, reads));
    EXPECT_TRUE(line.ledger.in_doubt(line.now, {.unit = 5}));
    EXPECT_FALSE(line.ledger.in_doubt(line.now, {.unit = 5, .function = 4}));
    EXPECT_FALSE(line.ledger.in_doubt(line.now, {.unit = 6, .function = 3}));
    EXPECT_FALSE(line.ledger.in_doubt(Line::at(7min), reads));
}

// The own answer was received damaged, as a copy of another, or with the length of another one.
TEST(Ledger, WhatAnsweredARequestMayHaveBeenSomethingElse) {
    ByteVector damaged = framed({5, 3, 2, 0, 9});
    damaged.back() ^= 1U;
    Line line;
    line.read(0ms, 0);
    line.ledger.on_heard(Line::at(10ms), damaged);
    line.exchange(100ms, 1);
    line.exchange(200ms, 2);
    line.read(300ms, 1);
    line.one(310ms, 9);
    EXPECT_EQ(line.exempt(9), "exempt_passed") << "undamaged";

    Line copied;
    copied.exchange(0ms, 7);
    copied.exchange(100ms, 7);
    copied.exchange(200ms, 8);
    copied.exchange(300ms, 9);
    copied.read(400ms, 1);
    copied.one(410ms, 6);
    EXPECT_EQ(copied.exempt(6), "exempt_passed") << "that of 100 ms";
}

TEST(Ledger, AfterAnExceptionThatMayRefuseAnotherRequestTheOwnAnswerMayFollow) {
    for (const bool another : {true, false}) {
        Line line;
        line.exchange(0ms, 1);
        if (another) {
            line.read(100ms, 0, 2);
            line.exchange(300ms, 2);  // passes it
        }
        line.read(400ms, 0);
        line.hear(410ms, {0x83, 2});
        line.read(500ms, 1);
        line.one(510ms, 7);
        EXPECT_EQ(line.exempt(7), another ? "exempt_passed" : "");
    }
}

// A frame of another length may be the own answer with a wrong length.
TEST(Ledger, AnEarlierAnswerBeforeTheOwnOneIsInOrder) {
    Line line;
    line.read(0ms, 0);
    line.read(200ms, 1, 2);
    line.one(210ms, 7);
    line.two(220ms);
    line.read(300ms, 0);
    line.read(400ms, 1, 2);
    line.two(410ms);
    line.read(500ms, 1);
    line.one(510ms, 8);
    EXPECT_EQ(line.exempt(8), "exempt_passed");
}

TEST(Ledger, AnAnswerBehindOtherBytesDoesNotShowAnotherOrder) {
    for (const bool noise : {true, false}) {
        Line line;
        line.read(0ms, 0);
        line.read(200ms, 1, 2);
        line.two(210ms);
        const ByteVector others{0x5C, 0x82, 0xA3};
        if (noise) line.ledger.on_heard(Line::at(240ms), others);
        line.one(250ms, 7);
        line.read(300ms, 0);
        line.read(330ms, 1, 2);
        line.two(340ms);
        line.read(350ms, 1);
        line.one(360ms, 8);
        EXPECT_EQ(line.exempt(8), noise ? "exempt_passed" : "");
    }
}

TEST(Ledger, OnlyItsOwnUnitOvertakesARequest) {
    Line line;
    line.read(0ms, 0);
    line.now = Line::at(200ms);
    const Asked other = parse_request(wire::Framing::rtu, framed({6, 3, 0, 0, 0, 1})).value();
    line.ledger.on_sent(line.now, other);
    line.ledger.on_heard(Line::at(210ms), framed({6, 3, 2, 0, 1}));
    line.one(220ms, 7);
    line.read(300ms, 0);
    line.read(500ms, 1, 2);
    line.two(510ms);
    line.read(600ms, 1);
    line.one(610ms, 8);
    EXPECT_EQ(line.exempt(8), "exempt_passed") << "it has always answered in order";
}

}  // namespace ledger_test
}  // namespace takt::judge
