#include "takt/bus/echo_filter.hpp"

#include <gtest/gtest.h>

#include "rig.hpp"

namespace takt::bus {
namespace echo_filter_test {

using test::at;
using test::hex;
using namespace std::chrono_literals;
using ByteVector = std::vector<std::uint8_t>;

ByteVector vector_of(Bytes bytes) {
    return {bytes.begin(), bytes.end()};
}

TEST(EchoFilter, DropsTheRequestHeardInPieces) {
    const auto request = hex("01 03 00 00 00 01 84 0A");
    EchoFilter filter(Echo::automatic);
    filter.arm(request, false, at(10ms));
    const auto first = filter.filter(at(1ms), Bytes(request).first(5));
    EXPECT_EQ(first.consumed, 5U);
    EXPECT_FALSE(first.echo);
    EXPECT_TRUE(filter.holding());
    auto rest = vector_of(Bytes(request).subspan(5));
    rest.push_back(0x01);  // the response follows at once
    const auto second = filter.filter(at(20ms), rest);
    EXPECT_EQ(second.consumed, 3U);
    EXPECT_TRUE(second.echo);
    EXPECT_TRUE(second.released.empty());
    EXPECT_EQ(filter.filter(at(21ms), hex("01 03")).consumed, 0U);
}

TEST(EchoFilter, ReleasesWhatOnlyBeganLikeTheRequest) {
    const auto request = hex("01 03 00 00 00 01 84 0A");
    EchoFilter filter(Echo::automatic);
    filter.arm(request, false, at(10ms));
    EXPECT_EQ(filter.filter(at(1ms), hex("01")).consumed, 1U);
    const auto step = filter.filter(at(2ms), hex("03 02 12 34"));
    EXPECT_EQ(step.consumed, 1U);
    EXPECT_EQ(vector_of(step.released), hex("01 03"));
    EXPECT_FALSE(filter.holding());
}

TEST(EchoFilter, ReleasesWhenTheLineFallsSilent) {
    const auto request = hex("01 03 00 00 00 01 84 0A");
    EchoFilter filter(Echo::automatic);
    filter.arm(request, false, at(10ms));
    EXPECT_EQ(filter.filter(at(1ms), hex("01 03")).consumed, 2U);
    EXPECT_EQ(vector_of(filter.release()), hex("01 03"));
    EXPECT_EQ(filter.filter(at(5ms), hex("00 00")).consumed, 0U);
}

TEST(EchoFilter, OnAPseudoTerminalARepetitionIsTheResponseUnlessEchoesWereSeen) {
    const auto read = hex("01 03 00 00 00 01 84 0A");
    const auto write = hex("01 06 00 01 00 03 98 0B");
    EchoFilter filter(Echo::untimed);
    filter.arm(write, true, at(10ms));
    EXPECT_FALSE(filter.filter(at(1us), write).echo);
    filter.answered();
    filter.arm(read, false, at(30ms));
    EXPECT_TRUE(filter.filter(at(20ms), read).echo);
    filter.answered();
    filter.arm(write, true, at(50ms));
    EXPECT_TRUE(filter.filter(at(40ms), write).echo);
}

TEST(EchoFilter, AWriteThatIsRepeatedIsEchoOrResponse) {
    const auto read = hex("01 03 00 00 00 01 84 0A");
    const auto write = hex("01 06 00 01 00 03 98 0B");
    struct Case {
        const char* what;
        bool read_before;
        bool read_was_echoed;
        Duration received;
        bool echo;
    };
    constexpr Case kCases[] = {
        {"first request, too early for a response", false, false, 9ms, true},
        {"first request, a response could be there", false, false, 10ms, false},
        {"echoes are known, however late", true, true, 50ms, true},
        {"known to be without, however early", true, false, 1ms, false},
    };
    for (const auto& c : kCases) {
        EchoFilter filter(Echo::automatic);
        if (c.read_before) {
            filter.arm(read, false, at(10ms));
            if (c.read_was_echoed) {
                EXPECT_TRUE(filter.filter(at(1ms), read).echo);
            }
            filter.answered();
        }
        filter.arm(write, true, at(10ms));
        const auto step = filter.filter(at(c.received), write);
        EXPECT_EQ(step.echo, c.echo) << c.what;
        EXPECT_EQ(step.consumed, write.size()) << c.what;
        EXPECT_EQ(vector_of(step.released), c.echo ? ByteVector{} : write) << c.what;
    }
}

TEST(EchoFilter, OneSpoiltEchoDoesNotMakeTheNextOneAResponse) {
    const auto read = hex("01 03 00 00 00 01 84 0A");
    const auto write = hex("01 06 00 01 00 03 98 0B");
    EchoFilter filter(Echo::automatic);
    const auto ask = [&](Bytes received) {
        filter.arm(read, false, at(10ms));
        const bool echo = filter.filter(at(1ms), received).echo;
        filter.answered();
        return echo;
    };
    const auto repetition_is_echo = [&] {
        filter.arm(write, true, at(10ms));
        return filter.filter(at(1ms), write).echo;
    };
    const auto spoilt = hex("01 03 00 40 00 01 84 0A");
    EXPECT_TRUE(ask(read));
    EXPECT_FALSE(ask(spoilt));
    EXPECT_TRUE(repetition_is_echo());
    EXPECT_FALSE(ask(spoilt));
    EXPECT_TRUE(repetition_is_echo());
    EXPECT_FALSE(ask(spoilt));
    EXPECT_FALSE(repetition_is_echo()) << "there is no echo any more";
}

TEST(EchoFilter, ASpoiltStartOfTheEchoDoesNotMakeItAResponse) {
    const auto read = hex("01 03 00 00 00 01 84 0A");
    const auto write = hex("01 06 00 01 00 03 98 0B");
    EchoFilter filter(Echo::automatic);
    filter.arm(read, false, at(10ms));
    EXPECT_FALSE(filter.filter(at(1ms), hex("FF")).echo);
    EXPECT_TRUE(filter.take_repetition(at(2ms)));
    EXPECT_FALSE(filter.take_repetition(at(3ms))) << "there is one for each request";
    filter.answered();
    filter.arm(write, true, at(10ms));
    EXPECT_TRUE(filter.take_repetition(at(50ms)));
    EXPECT_FALSE(filter.take_repetition(at(60ms)));
}

TEST(EchoFilter, WhereEchoesCannotBeNothingIsHeldBack) {
    const auto write = hex("01 06 00 01 00 03 98 0B");
    EchoFilter filter(Echo::absent);
    filter.arm(write, true, at(10ms));
    EXPECT_EQ(filter.filter(at(1ms), write).consumed, 0U);
}

}  // namespace echo_filter_test
}  // namespace takt::bus
