#include "takt/wire/framer.hpp"

#include <gtest/gtest.h>

#include "bytes.hpp"

namespace takt::wire {
namespace {

using namespace std::chrono_literals;

TEST(RtuFramer, TellsARequestAtItsLastByte) {
    Framer framer({.framing = Framing::rtu, .side = Side::slave, .silence = 1750us});
    const auto step = framer.push(Instant{} + 1s, from_hex("10 03 00 00 00 02 C7 4A"));
    ASSERT_TRUE(step.complete);
    EXPECT_EQ(step.consumed, 8U);
    EXPECT_EQ(framer.frame().unit, UnitId{16});
    EXPECT_EQ(to_hex(framer.frame().pdu), "03 00 00 00 02");
}

}  // namespace
}  // namespace takt::wire
