#include "takt/bus/late_answers.hpp"

#include <gtest/gtest.h>

#include "rig.hpp"

namespace takt::bus {
namespace {

using test::at;
using test::hex;
using namespace std::chrono_literals;

constexpr UnitId kUnit{1};
constexpr AnswerShape kRead2{3, 6};
constexpr AnswerShape kRead4{3, 10};
constexpr AnswerShape kRead4Inputs{4, 10};

TEST(LateAnswers, HoldUpOnlyAnswersThatLookAlike) {
    LateAnswers late;
    late.expect(kUnit, kRead2, at(200ms));
    EXPECT_EQ(late.earliest(kUnit, kRead2), at(200ms));
    EXPECT_EQ(late.earliest(kUnit, kRead4), Instant::min());
    EXPECT_EQ(late.earliest(kUnit, kRead4Inputs), Instant::min());
    EXPECT_EQ(late.earliest(UnitId{2}, kRead2), Instant::min());
    EXPECT_EQ(late.earliest(kUnit, {3, 0}), at(200ms));  // a length that is not known could be any
    late.expire(at(199ms));
    EXPECT_EQ(late.earliest(kUnit, kRead2), at(200ms));
    late.expire(at(200ms));
    EXPECT_EQ(late.earliest(kUnit, kRead2), Instant::min());
}

TEST(LateAnswers, AreSettledByWhatTheyLookLike) {
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
        LateAnswers late;
        late.expect(kUnit, kRead2, at(200ms));
        EXPECT_EQ(late.settle(UnitId{c.unit}, hex(c.pdu)), c.settles) << c.pdu;
        EXPECT_EQ(late.earliest(kUnit, kRead2) == Instant::min(), c.settles) << c.pdu;
    }
}

TEST(LateAnswers, AnAmbiguousExceptionLeavesEitherResponse) {
    LateAnswers late;
    late.expect(kUnit, kRead2, at(200ms));
    EXPECT_TRUE(late.ambiguous(kUnit, 3));
    EXPECT_FALSE(late.ambiguous(kUnit, 4));
    late.expect_either(kUnit, kRead4, at(300ms));
    EXPECT_EQ(late.earliest(kUnit, kRead2), at(300ms));
    EXPECT_EQ(late.earliest(kUnit, kRead4), at(300ms));
    EXPECT_EQ(late.earliest(kUnit, {3, 4}), Instant::min());
    EXPECT_EQ(late.earliest(kUnit, kRead4Inputs), Instant::min());
    EXPECT_FALSE(late.settle(kUnit, hex("03 02 00 01")));  // with the address of this unit, but another's
    EXPECT_TRUE(late.settle(kUnit, hex("03 08 00 01 00 02 00 03 00 04")));
    EXPECT_EQ(late.earliest(kUnit, kRead4), Instant::min());
}

TEST(LateAnswers, SeveralAmbiguousExceptionsHoldUpTheWholeFunction) {
    LateAnswers late;
    late.expect(kUnit, kRead2, at(200ms));
    late.expect_either(kUnit, kRead4, at(300ms));
    late.expect_either(kUnit, kRead4, at(350ms));
    EXPECT_EQ(late.earliest(kUnit, {3, 4}), Instant::min());
    late.expect_either(kUnit, {3, 8}, at(400ms));
    EXPECT_EQ(late.earliest(kUnit, {3, 4}), at(400ms));
    EXPECT_TRUE(late.settle(kUnit, hex("03 02 00 01")));
}

TEST(LateAnswers, BeyondTheCapacityEverythingWaits) {
    LateAnswers late;
    late.expect(kUnit, kRead2, at(200ms));
    for (std::size_t i = 0; i < LateAnswers::kCapacity - 1; ++i) late.expect(UnitId{2}, kRead2, at(300ms));
    EXPECT_EQ(late.earliest(UnitId{9}, kRead4), Instant::min());
    late.expect(UnitId{2}, kRead2, at(300ms));
    EXPECT_EQ(late.earliest(UnitId{9}, kRead4), at(200ms));
}

}  // namespace
}  // namespace takt::bus
