// The frames that the fault injector recognises by its own rules.
#include "sim/faults/frames.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "support.hpp"
#include "takt/sim/random.hpp"

namespace takt::sim {
namespace frames_test {

using wire::Framing;

TEST(Misleading, IsWhatAnybodyCouldTakeForAFrame) {
    UnitSet units;
    units[1] = units[0] = true;
    const ByteVector frame = close_frame(Framing::rtu, {1, 0, {0x03, 0x02, 0x12, 0x34}});
    const ByteVector foreign = close_frame(Framing::rtu, {9, 0, {0x03, 0x02, 0x12, 0x34}});
    const ByteVector odd = close_frame(Framing::rtu, {1, 0, {0x41, 0x02, 0x12}});
    const auto found = [&](ByteVector bytes, std::size_t old = 0, bool clean = false, Bytes genuine = {}) {
        return misleads(Framing::rtu, bytes, old, clean, genuine, units);
    };
    EXPECT_TRUE(found(frame));
    EXPECT_FALSE(found(frame, 0, false, frame)) << "it was sent";
    EXPECT_FALSE(found(foreign)) << "there is no listener";
    EXPECT_TRUE(found(odd)) << "a silence ends it";
    ByteVector inside{7, 7, 7};
    inside.insert(inside.end(), frame.begin(), frame.end());
    EXPECT_TRUE(found(inside));
    EXPECT_FALSE(found(inside, inside.size())) << "all of it was there before";
    inside.push_back(9);
    EXPECT_TRUE(found(inside)) << "its length ends it";
    ByteVector joined(frame.begin(), frame.begin() + 3);
    joined.insert(joined.end(), frame.begin() + 3, frame.end());
    EXPECT_TRUE(found(joined, 3, true, {})) << "it begins in what was there before";
    EXPECT_FALSE(found(frame, 0, true, {})) << "a good frame by itself";
}

TEST(Misleading, AsciiInEitherCase) {
    UnitSet units;
    units[0x1A] = true;
    const ByteVector frame = close_frame(Framing::ascii, {0x1A, 0, {0x06, 0x00, 0x01, 0xAB, 0xCD}});
    ByteVector lower = frame;
    for (std::uint8_t& c : lower)
        if (c >= 'A' && c <= 'F') c |= 0x20;
    EXPECT_FALSE(misleads(Framing::ascii, lower, 0, false, frame, units)) << "it has the same meaning";
    EXPECT_TRUE(misleads(Framing::ascii, lower, 0, false, {}, units));
    ByteVector swapped = frame;  // the sum does not see it
    std::swap(swapped[9], swapped[11]);
    std::swap(swapped[10], swapped[12]);
    EXPECT_TRUE(misleads(Framing::ascii, swapped, 0, false, frame, units));
}

TEST(Misleading, OpenAndCloseAgreeWithTheWire) {
    Random random(5);
    for (const Framing framing : {Framing::rtu, Framing::ascii, Framing::tcp})
        for (int i = 0; i < 50; ++i) {
            OpenFrame frame{static_cast<std::uint8_t>(random.below(256)), 0, {}};
            if (framing == Framing::tcp) frame.transaction = static_cast<std::uint16_t>(random.next());
            for (std::uint32_t n = 1 + random.below(250); n > 0; --n)
                frame.pdu.push_back(static_cast<std::uint8_t>(random.next()));
            const auto engine = wire::encode_frame(framing, UnitId{frame.unit}, frame.transaction, frame.pdu);
            EXPECT_TRUE(std::ranges::equal(engine.span(), close_frame(framing, frame)));
            const auto open = open_frame(framing, engine.span());
            ASSERT_TRUE(open);
            EXPECT_EQ(open->pdu, frame.pdu);
        }
}

}  // namespace frames_test
}  // namespace takt::sim
