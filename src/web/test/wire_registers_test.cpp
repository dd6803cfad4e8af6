#include "live/wire_registers.hpp"

#include <gtest/gtest.h>

#include <utility>

namespace takt::web {
namespace wire_registers_test {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

constexpr auto kHolding = wire::Area::holding_register;
const Bytes kRead{3, 0, 10, 0, 3};
const Bytes kAnswer{3, 6, 0x12, 0x34, 0, 1, 0xFF, 0xFE};

TrafficFrame frame(bool request, Bytes pdu, Instant t = Instant{1s}, std::uint16_t transaction = 0) {
    TrafficFrame made{.line = "bus", .mbap = transaction != 0, .request = request};
    made.record.t = t;
    made.record.unit = UnitId{16};
    made.record.pdu = std::move(pdu);
    made.record.raw = {static_cast<std::uint8_t>(transaction >> 8),
                       static_cast<std::uint8_t>(transaction & 0xFF),
                       0,
                       0,
                       0,
                       6,
                       16};
    return made;
}

TEST(WireRegisters, HaveTheRegistersOfAResponse) {
    WireRegisters known;
    EXPECT_FALSE(known.find("bus", UnitId{16}, kHolding, 10, 1));
    known.take(frame(true, kRead));
    known.take(frame(false, kAnswer, Instant{2s}));
    const auto found = known.find("bus", UnitId{16}, kHolding, 11, 2);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->items, (std::vector<std::uint16_t>{1, 0xFFFE}));
    EXPECT_EQ(found->start, 10);
    EXPECT_EQ(found->quantity, 3);
    EXPECT_EQ(found->t, Instant{2s});
    EXPECT_FALSE(known.find("bus", UnitId{16}, kHolding, 12, 2)) << "beyond its end";
    EXPECT_FALSE(known.find("bus", UnitId{16}, kHolding, 9, 1));
    EXPECT_FALSE(known.find("bus", UnitId{17}, kHolding, 10, 1));
    EXPECT_FALSE(known.find("other", UnitId{16}, kHolding, 10, 1));
    EXPECT_FALSE(known.find("bus", UnitId{16}, wire::Area::input_register, 10, 1));
}

TEST(WireRegisters, HaveBitsFromTheLowestOn) {
    WireRegisters known;
    known.take(frame(true, {1, 0, 4, 0, 10}));
    known.take(frame(false, {1, 2, 0b10000010, 0b10}));
    EXPECT_EQ(known.find("bus", UnitId{16}, wire::Area::coil, 5, 1)->items[0], 1);
    EXPECT_EQ(known.find("bus", UnitId{16}, wire::Area::coil, 6, 1)->items[0], 0);
    EXPECT_EQ(known.find("bus", UnitId{16}, wire::Area::coil, 13, 1)->items[0], 1);
}

TEST(WireRegisters, PreferTheNewestResponse) {
    WireRegisters known;
    known.take(frame(true, kRead));
    known.take(frame(false, kAnswer, Instant{2s}));
    known.take(frame(true, {3, 0, 10, 0, 1}));
    known.take(frame(false, {3, 2, 0, 9}, Instant{3s}));
    EXPECT_EQ(known.find("bus", UnitId{16}, kHolding, 10, 1)->items[0], 9);
    EXPECT_EQ(known.find("bus", UnitId{16}, kHolding, 10, 2)->items[0], 0x1234);
}

TEST(WireRegisters, IgnoreWhatDoesNotAnswerTheRequest) {
    WireRegisters known;
    known.take(frame(false, kAnswer));
    known.take(frame(true, kRead));
    known.take(frame(false, {0x83, 2}));
    known.take(frame(false, kAnswer));
    known.take(frame(true, {3, 0, 10, 0, 2}));
    known.take(frame(false, kAnswer));
    known.take(frame(true, {6, 0, 10, 0, 1}));
    known.take(frame(false, {6, 0, 10, 0, 1}));
    EXPECT_FALSE(known.find("bus", UnitId{16}, kHolding, 10, 1));
}

TEST(WireRegisters, MatchTransactionIdentifiers) {
    WireRegisters known;
    known.take(frame(true, kRead, Instant{1s}, 7));
    known.take(frame(true, {3, 0, 90, 0, 3}, Instant{1s}, 8));
    known.take(frame(false, kAnswer, Instant{2s}, 7));
    EXPECT_TRUE(known.find("bus", UnitId{16}, kHolding, 10, 3));
    EXPECT_FALSE(known.find("bus", UnitId{16}, kHolding, 90, 3));
}

}  // namespace wire_registers_test
}  // namespace takt::web
