// The lengths of silences, and that the rounded ones follow from them.
#include "takt/wire/silence.hpp"

#include <gtest/gtest.h>

namespace takt::wire {
namespace silence_test {

using namespace std::chrono_literals;

TEST(Silence, OfTheSpecification) {
    for (const std::uint32_t baud : {300U, 9600U, 19200U}) {
        const CharacterFormat format{.baud = baud};
        EXPECT_EQ(silence_in_frame(format).half_characters, 3U);
        EXPECT_EQ(silence_between_frames(format).half_characters, 7U);
        EXPECT_EQ(silence_between_frames(format).fixed, 0us);
    }
    for (const std::uint32_t baud : {19201U, 115200U}) {
        const CharacterFormat format{.baud = baud};
        EXPECT_EQ(silence_in_frame(format).fixed, 750us);
        EXPECT_EQ(silence_between_frames(format).fixed, 1750us);
        EXPECT_EQ(silence_between_frames(format).half_characters, 0U);
        EXPECT_EQ(t3_5(format), 1750us);
    }
}

TEST(Silence, SeparatesFramesOnSerialRtuLinesOnly) {
    const CharacterFormat slow{.baud = 9600};  // 11 bits
    EXPECT_EQ(frame_silence(Framing::rtu, slow), t3_5(slow));
    EXPECT_EQ(frame_silence(Framing::ascii, slow), 0ns);
    EXPECT_EQ(frame_silence(Framing::tcp, slow), 0ns);
    EXPECT_EQ(frame_silence(Framing::rtu, {.baud = 0}), 0ns) << "RTU in a stream";
    EXPECT_EQ(response_wait(Framing::rtu, slow, 1ms), t3_5(slow));
    EXPECT_EQ(response_wait(Framing::rtu, slow, 1s), 1s);
    EXPECT_EQ(response_wait(Framing::ascii, slow, 1ms), 1ms);
}

}  // namespace silence_test
}  // namespace takt::wire
