// The parts without a descriptor: marks of a serial driver, direction of RS-485, pauses between attempts.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <vector>

#include "loop/marked_input.hpp"
#include "network/backoff.hpp"
#include "serial/direction_switch.hpp"

namespace takt::line {
namespace line_parts_test {

using namespace std::chrono_literals;
using Input = std::vector<std::uint8_t>;

Input decode(MarkedInput& input, Input bytes) {
    bytes.resize(input.decode(bytes));
    return bytes;
}

TEST(MarkedInput, TakesOutMarks) {
    MarkedInput input;
    EXPECT_EQ(decode(input, {0x10, 0x03, 0x00}), (Input{0x10, 0x03, 0x00}));
    EXPECT_EQ(decode(input, {0x01, 0xFF, 0xFF, 0x02}), (Input{0x01, 0xFF, 0x02}));
    EXPECT_EQ(decode(input, {0x01, 0xFF, 0x00, 0x41, 0x02}), (Input{0x01, 0xBE, 0x02})) << "faulty: inverted";
    EXPECT_EQ(decode(input, {0x01, 0xFF, 0x00, 0x00, 0x02}), (Input{0x01, 0x02})) << "a break is left out";
    EXPECT_EQ(input.faulty_characters(), 1u);
    EXPECT_EQ(input.breaks(), 1u);
}

// Good characters that a driver marked (PARMRK) are restored, however the input is cut.
RC_GTEST_PROP(MarkedInput, KeepsGoodCharactersInAnyChunks, (std::uint8_t chunk)) {
    const auto sent =
        *rc::gen::container<Input>(rc::gen::element<std::uint8_t>(0x00, 0x01, 0x7F, 0xFE, 0xFF));
    Input marked;
    for (const auto byte : sent) marked.insert(marked.end(), byte == 0xFF ? 2 : 1, byte);
    MarkedInput input;
    Input got;
    const std::size_t step = 1 + chunk % 7;
    for (std::size_t at = 0; at < marked.size(); at += step) {
        const auto first = marked.begin() + static_cast<std::ptrdiff_t>(at);
        const auto last = marked.begin() + static_cast<std::ptrdiff_t>(std::min(at + step, marked.size()));
        const auto part = decode(input, Input(first, last));
        got.insert(got.end(), part.begin(), part.end());
    }
    RC_ASSERT(got == sent);
    RC_ASSERT(input.faulty_characters() == 0u);
}

constexpr wire::CharacterFormat k9600{9600, 8, wire::Parity::none, 1};  // a character: 1041.667 us

TEST(DirectionSwitch, WaitsForTheLastStopBit) {
    DirectionSwitch direction(k9600);
    const Instant start{};
    EXPECT_EQ(direction.next_check(), kNever);
    direction.sent(start, 8);
    const Instant end = start + wire::transmission_time(k9600, 8);
    EXPECT_EQ(direction.next_check(), end);
    EXPECT_FALSE(direction.release(end - 1ns, true)) << "the time counts, not the state of the transmitter";
    EXPECT_FALSE(direction.release(end, false));
    EXPECT_GT(direction.next_check(), end);
    EXPECT_LT(direction.next_check(), end + wire::transmission_time(k9600, 1));
    EXPECT_TRUE(direction.release(direction.next_check(), true));
    EXPECT_EQ(direction.next_check(), kNever);
}

TEST(DirectionSwitch, AddsUpWhatFollowsEachOther) {
    DirectionSwitch direction(k9600);
    direction.sent(Instant{}, 10);
    direction.sent(Instant{} + 1ms, 10);  // still sending the first
    EXPECT_EQ(direction.next_check(), Instant{} + 2 * wire::transmission_time(k9600, 10));
    EXPECT_TRUE(direction.release(direction.next_check(), true));
    direction.sent(Instant{} + 1s, 10);
    EXPECT_EQ(direction.next_check(), Instant{} + 1s + wire::transmission_time(k9600, 10));
}

TEST(DirectionSwitch, GivesAMillisecondToAnAdapterWithoutReport) {
    DirectionSwitch direction(k9600);
    direction.sent(Instant{}, 8);
    const Instant end = direction.next_check();
    EXPECT_FALSE(direction.release(end, std::nullopt));
    EXPECT_EQ(direction.next_check(), end + 1ms);
    EXPECT_TRUE(direction.release(end + 1ms, std::nullopt));
}

TEST(DirectionSwitch, DoesNotWaitForAStuckPortForEver) {
    DirectionSwitch direction(k9600);
    direction.sent(Instant{}, 8);
    const Instant end = direction.next_check();
    EXPECT_FALSE(direction.release(end + 999ms, false));
    EXPECT_TRUE(direction.release(end + 1s, false));
}

TEST(Backoff, DoublesToItsLimitAndBeginsAnew) {
    Backoff backoff;
    for (const Duration pause : {250ms, 500ms, 1000ms, 2000ms, 4000ms, 5000ms, 5000ms})
        EXPECT_EQ(backoff.next(), pause);
    backoff.reset();
    EXPECT_EQ(backoff.next(), 250ms);
}

}  // namespace line_parts_test
}  // namespace takt::line
