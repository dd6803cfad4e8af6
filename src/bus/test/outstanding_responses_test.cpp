#include "takt/bus/outstanding_responses.hpp"

#include <gtest/gtest.h>

#include "rig.hpp"

namespace takt::bus {
namespace outstanding_responses_test {

using test::at;
using test::hex;
using namespace std::chrono_literals;

constexpr UnitId kUnit{1};
constexpr AnswerShape kRead2{3, 6};
constexpr AnswerShape kRead4{3, 10};
constexpr AnswerShape kRead4Inputs{4, 10};

/// Outstanding responses with their memory; all are held until an instant and remembered for ten seconds.
struct Outstanding {
    void expect(UnitId unit, const AnswerShape& shape, Instant until) {
        responses.add({.unit = unit,
                       .shape = shape,
                       .expired_at = at(100ms),
                       .hold_until = until,
                       .confirm_until = until + 1s,
                       .forget_at = until + 10s,
                       .hold = 50ms,
                       .wait = 100ms});
    }
    [[nodiscard]] Ambiguity at_time(Duration t, const AnswerShape& shape) const {
        const Ambiguity ambiguity = responses.ambiguity(at(t), kUnit, shape);
        EXPECT_TRUE(ambiguity == Ambiguity::none || responses.any_ambiguity(at(t)));
        return ambiguity;
    }
    bool settle(const char* pdu, Duration t = 1s) {
        return responses.settle(kUnit, frame_shape(hex(pdu)), std::nullopt, at(t), at(t)) != Lateness::none;
    }
    std::array<OutstandingResponse, 32> memory;
    OutstandingResponses responses{memory};
};

TEST(OutstandingResponses, HoldUpOnlyResponsesThatLookAlike) {
    Outstanding late;
    late.expect(kUnit, kRead2, at(200ms));
    const auto& responses = late.responses;
    EXPECT_EQ(responses.earliest(kUnit, kRead2), at(200ms));
    EXPECT_EQ(responses.earliest(kUnit, kRead4), Instant::min());
    EXPECT_EQ(responses.earliest(kUnit, kRead4Inputs), Instant::min());
    EXPECT_EQ(responses.earliest(UnitId{2}, kRead2), Instant::min());
    EXPECT_EQ(responses.earliest(kUnit, {3, 0}), at(200ms));  // a length that is not known could be any
    EXPECT_EQ(late.at_time(199ms, kRead2), Ambiguity::held);
    EXPECT_EQ(late.at_time(200ms, kRead2), Ambiguity::doubted);
    EXPECT_EQ(late.at_time(100ms, kRead4), Ambiguity::none);
    late.responses.expire(at(10199ms));
    EXPECT_EQ(late.at_time(300ms, kRead2), Ambiguity::doubted);
    late.responses.expire(at(10200ms));
    EXPECT_EQ(late.at_time(300ms, kRead2), Ambiguity::none);
    EXPECT_FALSE(late.responses.any_ambiguity(at(300ms)));
}

TEST(OutstandingResponses, AreSettledByFramesThatLookAlike) {
    struct Case {
        const char* pdu;
        std::uint8_t unit;
        bool settles;
    };
    constexpr Case kCases[] = {
        {"03 04 00 01 00 02", 1, true},  {"83 02", 1, true},  {"03 02 00 01", 1, false},
        {"04 04 00 01 00 02", 1, false}, {"84 02", 1, false}, {"03 04 00 01 00 02", 2, false},
    };
    for (const auto& c : kCases) {
        Outstanding late;
        late.expect(kUnit, kRead2, at(200ms));
        EXPECT_EQ(late.responses.settle(UnitId{c.unit}, frame_shape(hex(c.pdu)), std::nullopt, at(1s),
                                        at(1s)) != Lateness::none,
                  c.settles)
            << c.pdu;
        EXPECT_EQ(late.at_time(100ms, kRead2) == Ambiguity::none, c.settles) << c.pdu;
        EXPECT_EQ(late.responses.take_late().has_value(), c.settles) << c.pdu;
    }
}

TEST(OutstandingResponses, PassWhenTheirUnitAnswersADistinguishableRequest) {
    Outstanding late;
    late.expect(kUnit, kRead2, at(200ms));
    late.responses.answered(at(120ms), UnitId{2}, kRead4);
    late.responses.answered(at(120ms), kUnit, kRead2);
    EXPECT_EQ(late.at_time(150ms, kRead2), Ambiguity::held) << "another unit, or one that looks alike";
    late.responses.answered(at(120ms), kUnit, kRead4);
    EXPECT_EQ(late.at_time(150ms, kRead2), Ambiguity::passed);
    EXPECT_EQ(late.responses.earliest(kUnit, kRead2), Instant::min());
    ASSERT_TRUE(late.settle("03 04 00 01 00 02"));
    const auto response = late.responses.take_late();
    ASSERT_TRUE(response);
    EXPECT_EQ(response->out_of_order_since, at(100ms));
}

TEST(OutstandingResponses, ShowThatTheUnitDoesNotAnswerInOrder) {
    for (const bool older_first : {true, false}) {
        Outstanding late;
        late.expect(kUnit, kRead2, at(200ms));
        late.expect(kUnit, kRead4, at(200ms));
        const char* const older = "03 04 00 01 00 02";
        const char* const newer = "03 08 00 01 00 02 00 03 00 04";
        ASSERT_TRUE(late.settle(older_first ? older : newer, 150ms));
        EXPECT_FALSE(late.responses.take_late()->out_of_order_since);
        EXPECT_EQ(late.at_time(160ms, older_first ? kRead4 : kRead2), Ambiguity::held);
        ASSERT_TRUE(late.settle(older_first ? newer : older, 170ms));
        EXPECT_NE(late.responses.take_late()->out_of_order_since.has_value(), older_first);
    }
}

// The frame may answer the one that has passed, or the one that is still waited for.
TEST(OutstandingResponses, ThoseThatHavePassedAreSettledFirstIfTheUnitDoesNotAnswerInOrder) {
    for (const bool in_order : {true, false}) {
        Outstanding late;
        late.expect(kUnit, kRead2, at(200ms));
        late.responses.answered(at(120ms), kUnit, kRead4);
        late.responses.add({.unit = kUnit,
                            .in_order = in_order,
                            .shape = kRead2,
                            .expired_at = at(300ms),
                            .hold_until = at(400ms),
                            .forget_at = at(10s)});
        EXPECT_TRUE(late.settle("03 04 00 01 00 02", 350ms));
        EXPECT_EQ(late.at_time(390ms, kRead2), in_order ? Ambiguity::passed : Ambiguity::held);
    }
}

TEST(OutstandingResponses, AreSuspectedAndPassWhenNothingFollowsAResponseThatLooksAlike) {
    Outstanding late;
    late.expect(kUnit, kRead2, at(200ms));
    late.responses.confirmed(at(310ms), kUnit, kRead2, at(300ms), true);
    EXPECT_EQ(late.at_time(359ms, kRead2), Ambiguity::held);
    EXPECT_EQ(late.at_time(360ms, kRead2), Ambiguity::suspected);
    late.responses.confirmed(at(410ms), kUnit, kRead2, at(400ms), true);
    EXPECT_EQ(late.at_time(400ms, kRead2), Ambiguity::passed);
    ASSERT_TRUE(late.settle("03 04 00 01 00 02", 500ms));
    EXPECT_EQ(late.responses.take_late()->delay, 100ms) << "the response to the last request";
}

TEST(OutstandingResponses, TheDelayIsThatOfTheOldestAndAtLeastThatOfTheNewest) {
    Outstanding late;
    for (const Duration end : {50ms, 450ms})
        late.responses.add({.unit = kUnit,
                            .shape = kRead2,
                            .end = at(end),
                            .expired_at = at(end + 100ms),
                            .forget_at = at(10s)});
    ASSERT_TRUE(late.settle("03 04 00 01 00 02", 700ms));
    const auto came = late.responses.take_late();
    ASSERT_TRUE(came);
    EXPECT_EQ(came->delay, 650ms);
    EXPECT_EQ(came->least_delay, 250ms);
}

// The response was the one that had passed, as it seems: then that to its request is missing.
TEST(OutstandingResponses, OnesThatHavePassedAreConfirmedLongerAfterAResponseInDoubt) {
    for (const bool in_doubt : {false, true}) {
        Outstanding late;
        late.expect(kUnit, kRead2, at(200ms));
        late.responses.answered(at(1150ms), kUnit, kRead4);
        EXPECT_EQ(late.at_time(1199ms, kRead2), Ambiguity::passed);
        late.responses.confirmed(at(1199ms), kUnit, kRead2, at(1190ms), in_doubt);
        EXPECT_EQ(late.at_time(1900ms, kRead2), in_doubt ? Ambiguity::passed : Ambiguity::none);
    }
}

TEST(OutstandingResponses, AnAmbiguousExceptionLeavesEitherResponse) {
    Outstanding late;
    late.expect(kUnit, kRead2, at(200ms));
    EXPECT_TRUE(late.responses.ambiguous(kUnit, 3));
    EXPECT_FALSE(late.responses.ambiguous(kUnit, 4));
    late.responses.expect_either(kUnit, kRead4, at(300ms));
    EXPECT_EQ(late.responses.earliest(kUnit, kRead2), at(300ms));
    EXPECT_EQ(late.responses.earliest(kUnit, kRead4), at(300ms));
    EXPECT_EQ(late.responses.earliest(kUnit, {3, 4}), Instant::min());
    EXPECT_EQ(late.responses.earliest(kUnit, kRead4Inputs), Instant::min());
    EXPECT_FALSE(late.settle("03 02 00 01"));  // with the address of this unit, but another's
    EXPECT_TRUE(late.settle("03 08 00 01 00 02 00 03 00 04"));
    EXPECT_EQ(late.responses.earliest(kUnit, kRead4), Instant::min());
}

TEST(OutstandingResponses, SeveralAmbiguousExceptionsHoldUpTheWholeFunction) {
    Outstanding late;
    late.expect(kUnit, kRead2, at(200ms));
    late.responses.expect_either(kUnit, kRead4, at(300ms));
    late.responses.expect_either(kUnit, kRead4, at(350ms));
    EXPECT_EQ(late.responses.earliest(kUnit, {3, 4}), Instant::min());
    late.responses.expect_either(kUnit, {3, 8}, at(400ms));
    EXPECT_EQ(late.responses.earliest(kUnit, {3, 4}), at(400ms));
    EXPECT_TRUE(late.settle("03 02 00 01"));
}

// A device that was busy for long works off all requests.
TEST(OutstandingResponses, OfOneShapeAllAreCounted) {
    Outstanding late;
    const std::size_t count = 3 * OutstandingResponses::kAlike;
    for (std::size_t i = 0; i < count; ++i) late.expect(kUnit, kRead2, at(200ms + i * 10ms));
    std::size_t taken = 0;
    for (std::size_t i = 0; i < count; ++i) {
        EXPECT_TRUE(late.settle("03 04 00 01 00 02")) << i;
        if (late.responses.take_late()) ++taken;
    }
    EXPECT_FALSE(late.settle("03 04 00 01 00 02"));
    EXPECT_EQ(taken, count);
}

TEST(OutstandingResponses, AnExceptionSettlesNoneOfDifferentLengths) {
    Outstanding late;
    late.expect(kUnit, kRead2, at(200ms));
    late.expect(kUnit, kRead4, at(200ms));
    EXPECT_TRUE(late.settle("83 02"));
    EXPECT_EQ(late.at_time(100ms, kRead2), Ambiguity::held);
    EXPECT_EQ(late.at_time(100ms, kRead4), Ambiguity::held);
}

/// The shape of the response to a read of that many registers.
AnswerShape read_of(std::size_t registers) {
    return {3, static_cast<std::uint16_t>(2 + 2 * registers)};
}

TEST(OutstandingResponses, BeyondTheCapacityThoseThatHavePassedAreForgotten) {
    Outstanding late;
    late.expect(kUnit, kRead2, at(200ms));
    late.responses.answered(at(120ms), kUnit, kRead4);
    for (std::size_t i = 0; i < late.memory.size(); ++i) late.expect(UnitId{2}, read_of(i), at(300ms));
    EXPECT_FALSE(late.responses.remembers(kUnit));
    EXPECT_EQ(late.responses.earliest(UnitId{2}, {3, 0x1234}), Instant::min());
}

TEST(OutstandingResponses, BeyondTheCapacityTwoOfOneUnitShareAnEntryThatMatchesAllLengths) {
    Outstanding late;
    for (std::size_t i = 0; i <= late.memory.size(); ++i) late.expect(kUnit, read_of(i), at(200ms));
    EXPECT_EQ(late.responses.earliest(kUnit, {3, 0x1234}), at(200ms));
    EXPECT_EQ(late.responses.earliest(UnitId{2}, kRead2), Instant::min());
    EXPECT_TRUE(late.settle("03 02 00 01"));
    EXPECT_TRUE(late.settle("03 02 00 01"));
    EXPECT_FALSE(late.settle("03 02 00 01"));
}

// The unit is in doubt until it is known: also if the memory is full of others, and several look alike.
TEST(OutstandingResponses, BeyondTheCapacityALateResponseIsGivenToo) {
    Outstanding late;
    for (std::size_t i = 0; i <= OutstandingResponses::kAlike; ++i) late.expect(kUnit, kRead2, at(200ms));
    for (std::size_t i = OutstandingResponses::kAlike; i < late.memory.size(); ++i)
        late.expect(kUnit, read_of(10 + i), at(200ms));
    late.responses.answered(at(120ms), kUnit, AnswerShape{4, 4});
    for (std::size_t i = 0; i <= OutstandingResponses::kAlike; ++i) {
        EXPECT_TRUE(late.settle("03 04 00 01 00 02"));
        EXPECT_TRUE(late.responses.take_late()) << i;
    }
}

// So that none with the length of a frame that came seems to be missing, and none that is missing is
// forgotten.
TEST(OutstandingResponses, AFrameSettlesAnEntryOfItsOwnLengthBeforeASharedOne) {
    Outstanding late;
    for (std::size_t i = 0; i < late.memory.size(); ++i) late.expect(kUnit, read_of(i), at(200ms));
    const auto own = read_of(late.memory.size() - 1);
    late.expect(kUnit, read_of(late.memory.size()), at(200ms));  // the first two share an entry now
    EXPECT_EQ(late.responses.settle(kUnit, own, std::nullopt, at(1s), at(1s)), Lateness::in_order);
    EXPECT_EQ(late.responses.settle(kUnit, own, std::nullopt, at(1s), at(1s)), Lateness::in_order);
    EXPECT_EQ(late.responses.settle(kUnit, own, std::nullopt, at(1s), at(1s)), Lateness::in_order);
    EXPECT_EQ(late.responses.settle(kUnit, own, std::nullopt, at(1s), at(1s)), Lateness::none);
    for (std::size_t i = 2; i + 1 < late.memory.size(); ++i)
        EXPECT_NE(late.responses.settle(kUnit, read_of(i), std::nullopt, at(1s), at(1s)), Lateness::none)
            << i;
}

TEST(OutstandingResponses, BeyondTheCapacityOfOnePerUnitEverythingWaits) {
    Outstanding late;
    for (std::size_t i = 0; i < late.memory.size(); ++i)
        late.expect(UnitId{static_cast<std::uint8_t>(i + 1)}, kRead2, at(200ms));
    EXPECT_EQ(late.responses.earliest(UnitId{99}, kRead4), Instant::min());
    late.expect(UnitId{90}, kRead2, at(300ms));
    EXPECT_EQ(late.responses.earliest(UnitId{99}, kRead4), at(200ms));
}

// ---- memory

struct Lender final : ResponseMemory {
    std::span<OutstandingResponse> lend() override {
        ++lent;
        return memory;
    }
    std::array<OutstandingResponse, 2> memory;
    int lent = 0;
};

TEST(OutstandingResponses, MemoryIsLentWhenTheFirstResponseIsMissing) {
    const OutstandingResponse missing{
        .unit = kUnit, .shape = kRead2, .hold_until = at(2s), .forget_at = at(9s)};
    Lender lender;
    OutstandingResponses responses({}, &lender);
    EXPECT_EQ(responses.ambiguity(at(1s), kUnit, kRead2), Ambiguity::none);
    EXPECT_EQ(responses.take_late(), std::nullopt);
    responses.expire(at(1s));
    responses.clear();
    OutstandingResponses next({}, &lender);
    next.take_over(responses);
    EXPECT_EQ(lender.lent, 0);
    responses.add(missing);
    responses.add(missing);
    EXPECT_EQ(lender.lent, 1);
    EXPECT_EQ(responses.ambiguity(at(1s), kUnit, kRead2), Ambiguity::held);
    Lender other;
    OutstandingResponses continued({}, &other);
    continued.take_over(responses);
    EXPECT_EQ(other.lent, 1);
    EXPECT_TRUE(continued.remembers(kUnit, kRead2));
    OutstandingResponses none({});
    none.add(missing);
    EXPECT_FALSE(none.remembers(kUnit, kRead2));
}

}  // namespace outstanding_responses_test
}  // namespace takt::bus
