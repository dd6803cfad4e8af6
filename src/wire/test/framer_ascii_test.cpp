#include <gtest/gtest.h>

#include "listener.hpp"

namespace takt::wire {
namespace framer_ascii_test {

using namespace std::chrono_literals;

constexpr FramerConfig kAscii{.framing = Framing::ascii};
constexpr std::string_view kGood = ":F7031389000A60\r\n";
constexpr std::string_view kGoodReport = "F7: 03 13 89 00 0A";
constexpr Instant at(Duration since_start) {
    return Instant{} + since_start;
}

// Hostile-inputs 44..47: each is followed by a good frame, which must be found.
TEST(AsciiFramer, ReportsFaultsAndGoesOn) {
    struct Row {
        std::string text;
        Reports reports;
    };
    const std::string good(kGoodReport);
    const Row rows[] = {
        {"", {good}},
        {"noise \r\n", {good}},
        {":f7031389000a60\r\n", {good, good}},
        {":F70313", {"!bad_character", good}},
        {":F7031389000A61\r\n", {"!checksum", good}},
        {":F7031389000A6\r\n", {"!bad_character", good}},
        {":F7031389000G60\r\n", {"!bad_character", good}},
        {":F703 1389000A60\r\n", {"!bad_character", good}},
        {":F7031389000A60\rX\n", {"!bad_character", good}},
        {":F7031389000A60\r\r\n", {"!bad_character", good}},
        {":F7031389000A60\n", {"!bad_character", good}},
        {":F7031389000A60\r", {"!bad_character", good}},
        {":\r\n", {"!too_short", good}},
        {":0100\r\n", {"!too_short", good}},
        {":" + std::string(510, '0') + "\r\n",
         {"00: " +
              [] {
                  std::string zeros = "00";
                  for (int i = 1; i < 253; ++i) zeros += " 00";
                  return zeros;
              }(),
          good}},
        {":" + std::string(511, '0') + "\r\n", {"!too_long", good}},
        {":" + std::string(100000, '0'), {"!too_long", good}},
        {std::string(100000, 'x'), {good}},
    };
    for (const auto& [text, reports] : rows) {
        Listener listener(kAscii);
        listener.text(at(1s), text);
        listener.text(at(1s), kGood);
        EXPECT_EQ(listener.reports(), reports) << text.substr(0, 20);
    }
}

TEST(AsciiFramer, GivesTheCharactersAsTheyWere) {
    Listener listener(kAscii);
    listener.text(at(1s), "??:f7031389000a60\r\n");
    const Bytes raw = listener.framer().raw();
    EXPECT_EQ(std::string(raw.begin(), raw.end()), ":f7031389000a60\r\n");
}

TEST(AsciiFramer, APauseInsideDropsTheFrame) {
    for (const bool ticked : {false, true}) {
        Listener listener(kAscii);
        listener.text(at(1s), ":F70313");
        EXPECT_EQ(listener.framer().next_wakeup(), at(2s));
        listener.tick(at(2s) - 1ns);
        listener.text(at(2s) - 1ns, "89");
        if (ticked) listener.tick(at(3s));
        EXPECT_EQ(listener.reports(), ticked ? Reports{"!pause"} : Reports{});
        listener.text(at(3s), "000A60\r\n");
        EXPECT_EQ(listener.reports(), ticked ? Reports{} : Reports{"!pause"});
        EXPECT_EQ(listener.framer().next_wakeup(), kNever);
        listener.text(at(3s), kGood);
        EXPECT_EQ(listener.reports(), Reports{std::string(kGoodReport)});
    }
}

TEST(AsciiFramer, FramesMayFollowEachOther) {
    Listener listener(kAscii);
    listener.text(at(1s), std::string(kGood) + std::string(kGood));
    EXPECT_EQ(listener.reports(), (Reports{std::string(kGoodReport), std::string(kGoodReport)}));
}

// The expected response is ":0103021234B4" and its end.
TEST(AsciiFramer, ReportsWhetherTheExpectedResponseCameDamaged) {
    struct Row {
        std::string_view text;
        bool whole;
        bool came;
    };
    constexpr Row kRows[] = {
        {":0103021235B4\r\n", true, true},     // a wrong value
        {":01030212X4B4\r\n", true, true},     // no digit
        {":1103021234B4\r\n", true, false},    // another unit
        {":01X3021234B4\r\n", true, false},    // its function is not known
        {":01030212345B4\r\n", false, false},  // a character too many
    };
    for (const auto& [text, whole, came] : kRows) {
        StandaloneFramer framer(kAscii, false);
        framer.expect_response({.unit = UnitId{1}, .function = 3, .length = 15});
        const ByteVector bytes(text.begin(), text.end());
        const FramerStep step = framer.push(at(1s), bytes);
        EXPECT_NE(step.fault, FrameFault::none) << text;
        EXPECT_EQ(step.whole, whole) << text;
        EXPECT_EQ(step.came, came) << text;
    }
}

}  // namespace framer_ascii_test
}  // namespace takt::wire
