#include "takt/wire/line_timing.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace takt::wire {
namespace line_timing_test {

using namespace std::chrono_literals;

constexpr CharacterFormat k8N1{115200, 8, Parity::none, 1};

TEST(CharacterFormat, CountsAllBits) {
    EXPECT_EQ((CharacterFormat{9600, 8, Parity::none, 1}.bits()), 10);
    EXPECT_EQ((CharacterFormat{9600, 8, Parity::even, 1}.bits()), 11);
    EXPECT_EQ((CharacterFormat{9600, 8, Parity::none, 2}.bits()), 11);
    EXPECT_EQ((CharacterFormat{9600, 7, Parity::even, 1}.bits()), 10);
}

TEST(LineTiming, RoundsUpOnce) {
    EXPECT_EQ(transmission_time(k8N1, 8), 694445ns) << "80 bits at 115200 bit/s are 694444.4 ns";
    EXPECT_EQ(transmission_time(k8N1, 144), 12500us) << "exact: nothing is added";
    EXPECT_EQ(transmission_time(k8N1, 0), 0ns);
    EXPECT_EQ(transmission_time({1, 8, Parity::none, 1}, 256), 2560s);
    EXPECT_EQ(transmission_time({0, 8, Parity::none, 1}, 256), 0ns) << "no serial line";
}

TEST(LineTiming, SilencesAreFixedAbove19200) {
    struct Case {
        std::uint32_t baud;
        Duration t1_5, t3_5;
    };
    constexpr Case kCases[] = {
        {9600, 1718750ns, 4010417ns},  // 11 bits: 16.5 and 38.5 bit times, 4010416.7 ns
        {19200, 859375ns, 2005209ns}, {19201, 750us, 1750us}, {115200, 750us, 1750us}, {0, 0us, 0us},
    };
    for (const auto& [baud, short_pause, silence] : kCases) {
        const CharacterFormat format{baud, 8, Parity::even, 1};
        EXPECT_EQ(t1_5(format), short_pause) << baud;
        EXPECT_EQ(t3_5(format), silence) << baud;
    }
}

RC_GTEST_PROP(LineTiming, IsTheLeastNanosecondNotBelowTheExactTime, ()) {
    const CharacterFormat format{*rc::gen::inRange<std::uint32_t>(1, 4'000'000'000), 8, Parity::even, 1};
    const auto characters = *rc::gen::inRange<std::uint64_t>(0, 1'000'000);
    __extension__ using Wide = unsigned __int128;
    const Wide exact = Wide{characters} * 11 * 1'000'000'000;  // nanoseconds times the rate
    const Wide time = static_cast<std::uint64_t>(transmission_time(format, characters).count());
    RC_ASSERT(time * format.baud >= exact);
    RC_ASSERT(time * format.baud < exact + format.baud);
}

}  // namespace line_timing_test
}  // namespace takt::wire
