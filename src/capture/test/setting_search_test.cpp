// The search of settings on simulated signals: all usual bit rates and formats, clocks that differ, noise, a
// start at any phase. The test prints the share that is recognised and how much of the line that takes.
#include "takt/capture/setting_search.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "uart.hpp"

namespace takt::capture {
namespace setting_search_test {

using namespace test;
using wire::Parity;

struct Search {
    std::optional<LineSetting> found;
    double seconds = 0;
    std::uint64_t frames = 0;  // sent until then
    std::size_t tried = 0;
};

Instant instant(double seconds) {
    return Instant(Duration(static_cast<std::int64_t>(seconds * 1e9)));
}

Search search(const SignalOptions& options, bool resynchronises = true, double limit = 600) {
    Signal signal(options);
    std::mt19937 rng(options.seed * 7919);
    const double start = std::uniform_real_distribution(0.0, 2.0)(rng);
    signal.level(start);
    const auto before = signal.sent();
    Uart uart(signal, start, resynchronises);
    SettingSearch search;
    double now = start;
    while (!search.found() && now - start < limit) {
        const auto received = uart.receive(search.format());
        now = received.time;
        search.on_characters(instant(now), {&received.character, 1});
    }
    return {search.found(), now - start, signal.sent() - before, search.tried()};
}

constexpr int kSeeds = 2;
constexpr std::array kFormats{
    wire::CharacterFormat{0, 8, Parity::none, 1}, wire::CharacterFormat{0, 8, Parity::even, 1},
    wire::CharacterFormat{0, 8, Parity::odd, 1}, wire::CharacterFormat{0, 8, Parity::none, 2}};

/// Results of many searches.
struct Tally {
    int right = 0;
    int wrong = 0;
    int open = 0;
    double frames = 0;
    double most_frames = 0;
    double seconds = 0;
    double most_seconds = 0;

    void count(const Search& result, const LineSetting& wanted) {
        ++(result.found == wanted ? right : result.found ? wrong : open);
        frames += static_cast<double>(result.frames);
        most_frames = std::max(most_frames, static_cast<double>(result.frames));
        seconds += result.seconds;
        most_seconds = std::max(most_seconds, result.seconds);
    }
    [[nodiscard]] int all() const { return right + wrong + open; }
    void print(const std::string& what) const {
        std::printf(
            "%-28s %3d of %3d right, %d wrong, %d open; %5.1f frames (%.0f at most), %5.1f s (%.1f)\n",
            what.c_str(), right, all(), wrong, open, frames / all(), most_frames, seconds / all(),
            most_seconds);
    }
};

Tally tally(SignalOptions options, wire::CharacterFormat format, bool resynchronises, int seeds) {
    Tally tally;
    for (const auto baud : SettingSearch::kBauds) {
        for (int seed = 1; seed <= seeds; ++seed) {
            std::mt19937 rng(static_cast<unsigned>(seed) * 31 + baud);
            format.baud = baud;
            options.format = format;
            options.seed = static_cast<unsigned>(rng());
            options.clock = std::uniform_real_distribution(0.985, 1.015)(rng);
            tally.count(search(options, resynchronises), {format, options.framing});
        }
    }
    return tally;
}

std::string text(const wire::CharacterFormat& format) {
    const char* const parity = format.parity == Parity::none   ? "N"
                               : format.parity == Parity::even ? "E"
                                                               : "O";
    return std::to_string(format.data_bits) + parity + std::to_string(format.stop_bits);
}

TEST(SettingSearch, FindsAllUsualSettings) {
    for (const bool resynchronises : {true, false})
        for (const auto& format : kFormats) {
            const auto result = tally({}, format, resynchronises, kSeeds);
            result.print(text(format) + (resynchronises ? "" : ", plain UART"));
            EXPECT_EQ(result.right, result.all());
        }
}

TEST(SettingSearch, FindsThemInNoise) {
    for (const auto& format : kFormats) {
        const auto result = tally({.glitches_per_bit = 1.0 / 1000}, format, true, kSeeds);
        result.print(text(format) + ", noise");
        EXPECT_GE(result.right * 100, result.all() * 97);
    }
}

TEST(SettingSearch, FindsThemOnABusyLine) {
    for (const auto& format : kFormats) {
        const auto result = tally({.busy = true}, format, true, 1);
        result.print(text(format) + ", busy");
        EXPECT_EQ(result.right, result.all());
    }
}

TEST(SettingSearch, FindsAsciiWithSevenAndEightBits) {
    for (const auto& format :
         {wire::CharacterFormat{0, 7, Parity::even, 1}, wire::CharacterFormat{0, 7, Parity::odd, 1},
          wire::CharacterFormat{0, 7, Parity::none, 2}, wire::CharacterFormat{0, 8, Parity::none, 1},
          wire::CharacterFormat{0, 8, Parity::even, 1}}) {
        const auto result = tally({.framing = wire::Framing::ascii}, format, true, 1);
        result.print(text(format) + ", ASCII");
        EXPECT_EQ(result.right, result.all());
    }
}

TEST(SettingSearch, TakesPausesBetweenCharactersForASecondStopBit) {
    const auto result = search({.format = {9600, 8, Parity::none, 1}, .pause = 20});
    ASSERT_TRUE(result.found);
    EXPECT_EQ(result.found->format, (wire::CharacterFormat{9600, 8, Parity::none, 2}));
}

TEST(SettingSearch, DoesNotFindWhatIsNotModbus) {
    SettingSearch search;
    std::mt19937 rng(5);
    for (int i = 0; i < 200'000; ++i) {
        const wire::Character character{static_cast<std::uint8_t>(rng()), rng() % 4 == 0};
        search.on_characters(instant(i * 0.001), {&character, 1});
    }
    EXPECT_FALSE(search.found());
    EXPECT_GT(search.tried(), 16U) << "it begins again";
}

TEST(SettingSearch, OfAPseudoTerminalOnlyTheFramingIsSearched) {
    for (const auto framing : {wire::Framing::rtu, wire::Framing::ascii}) {
        SettingSearch search(wire::CharacterFormat{19200, 8, Parity::even, 1});
        for (int i = 0; i < 3; ++i) {
            EXPECT_EQ(search.found().has_value(), i == 2);
            EXPECT_EQ(search.format(), (wire::CharacterFormat{19200, 8, Parity::even, 1}));
            const std::uint8_t pdu[]{3, 0, 0, 0, 1};
            std::vector<wire::Character> characters;
            for (const auto byte : wire::encode_frame(framing, UnitId{1}, 0, pdu))
                characters.push_back({byte, false});
            search.on_characters(instant(i), characters);
        }
        ASSERT_TRUE(search.found());
        EXPECT_EQ(search.found()->framing, framing);
        EXPECT_EQ(search.tried(), 1U);
    }
}

}  // namespace setting_search_test
}  // namespace takt::capture
