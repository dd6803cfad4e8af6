#include "takt/file/learnt.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "takt/text/catalogue.hpp"

namespace takt::file {
namespace learnt_test {

using namespace std::chrono_literals;
using model::ItemRange;

constexpr std::chrono::sys_seconds kNow = std::chrono::sys_days(std::chrono::year(2026) / 11 / 21) + 17h;
constexpr auto kHolding = static_cast<std::size_t>(wire::Area::holding_register);
constexpr auto kCoil = static_cast<std::size_t>(wire::Area::coil);

model::Project project() {
    model::Project made;
    made.lines.resize(2);
    made.lines[0].name = "north";
    made.lines[1].name = "south";
    for (auto& line : made.lines)
        for (const int address : {1, 2}) {
            auto& device = line.devices.emplace_back();
            device.name = "D" + std::to_string(address);
            device.address = UnitId{static_cast<std::uint8_t>(address)};
            device.gaps = model::Gaps::learn;
            device.strategy = model::Strategy::optimal;
        }
    return made;
}

LearntOfLines known() {
    LearntOfLines learnt(2, std::vector<model::Learnt>(2));
    auto& device = learnt[1][0];
    device.confirmed[kHolding] = {{0, 10}, {15, 65535}};
    device.refused[kHolding] = {{.items = {11, 14}, .exception = 2, .since = 26h, .checked = 1h}};
    device.confirmed[kCoil] = {{7, 7}};
    device.most_items[kCoil] = 60;
    learnt[0][1].refused[kHolding] = {{.items = {3, 3}, .exception = 4, .since = 5s, .checked = 0s}};
    return learnt;
}

TimesOfLines known_times() {
    TimesOfLines times(2, std::vector<model::LearntTimes>(2));
    times[0][0] = {.measured = {.exchanges = 3120,
                                .longest = 7612us,
                                .p999 = 7100us,
                                .attempts = 3124,
                                .late = 3,
                                .lateness = 412300us,
                                .next_latest = {{407100us, 398ms}}},
                   .counts = {{4095us, 3100}, {7679us, 20}}};
    times[1][0] = {.measured = {.attempts = 1, .late = 1, .lateness = 600ms}, .counts = {}};
    return times;
}

std::string codes(const Recalled& recalled) {
    std::string all;
    for (const auto& finding : recalled.findings) all += finding.code + "(" + finding.value + ") ";
    return all;
}

TEST(Learnt, ComesBackAsItWent) {
    const std::string text = learnt_text(project(), known(), known_times(), kNow);
    auto again = project();
    const auto recalled = recall(text, kNow, 0, again);
    EXPECT_TRUE(recalled.whole) << codes(recalled);
    EXPECT_TRUE(recalled.findings.empty());
    for (std::size_t l = 0; l < 2; ++l)
        for (std::size_t d = 0; d < 2; ++d) {
            EXPECT_EQ(again.lines[l].devices[d].learnt, known()[l][d]);
            EXPECT_EQ(again.lines[l].devices[d].times, known_times()[l][d]);
        }
    EXPECT_NE(text.find("2026-11-20T15:00:00Z"), std::string::npos) << text;
}

TEST(Learnt, TimeGoesOnWhileNothingRuns) {
    auto again = project();
    ASSERT_TRUE(recall(learnt_text(project(), known(), known_times(), kNow), kNow + 3h, 0, again).whole);
    EXPECT_EQ(again.lines[1].devices[0].learnt.refused[kHolding][0].checked, 4h);
    ASSERT_TRUE(recall(learnt_text(project(), known(), known_times(), kNow), kNow - 30h, 0, again).whole);
    EXPECT_EQ(again.lines[1].devices[0].learnt.refused[kHolding][0].checked, 0h) << "the clock was set back";
}

TEST(Learnt, WhatTheProjectDoesNotHaveIsSaidAndLeftOut) {
    const std::string text = learnt_text(project(), known(), known_times(), kNow);
    auto other = project();
    other.lines[0].name = "west";
    other.lines[1].devices[0].address = UnitId{9};
    const auto recalled = recall(text, kNow, 3, other);
    EXPECT_TRUE(recalled.whole);
    EXPECT_EQ(codes(recalled), "learnt.stale(D1) learnt.stale(D2) learnt.stale(D1) ");
    EXPECT_EQ(recalled.findings[0].location.file, 3U);
    for (const auto& line : other.lines)
        for (const auto& device : line.devices) {
            EXPECT_EQ(device.learnt, model::Learnt{});
            EXPECT_EQ(device.times, model::LearntTimes{});
        }
    auto never = project();
    never.lines[1].devices[0].gaps = model::Gaps::never;
    EXPECT_TRUE(recall(text, kNow, 0, never).findings.empty());
    EXPECT_EQ(never.lines[1].devices[0].learnt, model::Learnt{});
}

TEST(Learnt, WhatIsNoSuchFileIsNotTakenAtAll) {
    const std::string good = learnt_text(project(), known(), known_times(), kNow);
    const auto broken = [&](const std::string& from, const std::string& to) {
        std::string text = good;
        const auto at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        text.replace(at, from.size(), to);
        auto other = project();
        const auto recalled = recall(text, kNow, 0, other);
        EXPECT_FALSE(recalled.whole) << from << " -> " << to;
        for (const auto& line : other.lines)
            for (const auto& device : line.devices) {
                EXPECT_EQ(device.learnt, model::Learnt{});
                EXPECT_EQ(device.times, model::LearntTimes{});
            }
        return codes(recalled);
    };
    const std::string area = "lines[1].devices[0].areas[1]";
    EXPECT_EQ(broken("\"takt_learnt\": 2", "\"takt_learnt\": 3"), "learnt.damaged(takt_learnt) ");
    EXPECT_EQ(broken("\"lines\"", "\"line_\""), "learnt.damaged(.lines) ");
    EXPECT_EQ(broken("\"since\": \"2026-11-20T15:00:00Z\"", "\"since\": \"2026-02-30T15:00:00Z\""),
              "learnt.damaged(" + area + ".refused[0].since) ");
    EXPECT_EQ(broken("65535", "65536"), "learnt.damaged(" + area + ".confirmed[1]) ");
    EXPECT_EQ(broken("65535", "9"), "learnt.damaged(" + area + ".confirmed[1]) ");
    EXPECT_EQ(broken("65535", "70 "), "learnt.damaged(" + area + ".confirmed[1]) ");
    EXPECT_EQ(broken("\"exception\": 2", "\"exception\": 6"),
              "learnt.damaged(" + area + ".refused[0].exception) ");
    EXPECT_EQ(broken("\"area\": \"coil\"", "\"area\": \"oil\""),
              "learnt.damaged(lines[1].devices[0].areas[0].area) ");
    EXPECT_EQ(broken("\"address\": 1", "\"address\": -1"), "learnt.damaged(lines[0].devices[0].address) ");
    const std::string times = "lines[0].devices[0].times";
    EXPECT_EQ(broken("\"exchanges\": 3120", "\"exchanges\": 3121"),
              "learnt.damaged(" + times + ".exchanges) ");
    EXPECT_EQ(broken("\"p999_us\": 7100", "\"p999_us\": 7700"), "learnt.damaged(" + times + ".p999_us) ");
    EXPECT_EQ(broken("\"late\": 3", "\"late\": -3"), "learnt.damaged(" + times + ".late) ");
    EXPECT_EQ(broken("\"lateness_us\": 412300", "\"lateness_us\": 3600000001"),
              "learnt.damaged(" + times + ".lateness_us) ");
    EXPECT_EQ(broken("407100", "412301"), "learnt.damaged(" + times + ".next_latest_us[0]) ");
    EXPECT_EQ(broken("398000", "407101"), "learnt.damaged(" + times + ".next_latest_us[1]) ");
    EXPECT_EQ(broken("398000", "398000, 1"), "learnt.damaged(" + times + ".next_latest_us) ");
    EXPECT_EQ(broken("7679", "4095"), "learnt.damaged(" + times + ".counts[1]) ");
    EXPECT_EQ(broken("7679", "\"7679\""), "learnt.damaged(" + times + ".counts[1]) ");
    EXPECT_EQ(broken("{", ""), "learnt.damaged(JSON) ");
}

TEST(Learnt, AFileOfTheFirstVersionIsRead) {
    auto text = learnt_text(project(), known(), {}, kNow);
    EXPECT_EQ(text.find("times"), std::string::npos);
    text.replace(text.find("\"takt_learnt\": 2"), 16, "\"takt_learnt\": 1");
    auto again = project();
    EXPECT_TRUE(recall(text, kNow, 0, again).whole);
    EXPECT_EQ(again.lines[1].devices[0].learnt, known()[1][0]);
}

TEST(Learnt, TimesAreKeptOfDevicesThatLearnNothing) {
    auto plain = project();
    for (auto& device : plain.lines[0].devices) device.gaps = model::Gaps::never;
    auto again = plain;
    ASSERT_TRUE(recall(learnt_text(plain, known(), known_times(), kNow), kNow, 0, again).whole);
    EXPECT_EQ(again.lines[0].devices[0].times, known_times()[0][0]);
    EXPECT_EQ(again.lines[0].devices[1].learnt, model::Learnt{});
}

RC_GTEST_PROP(Learnt, NoDamageIsFatal, ()) {
    std::string text = learnt_text(project(), known(), known_times(), kNow);
    for (int i = *rc::gen::inRange(1, 6); i > 0; --i) {
        const auto at = static_cast<std::size_t>(*rc::gen::inRange(0, static_cast<int>(text.size())));
        if (*rc::gen::inRange(0, 3) == 0)
            text.resize(at);
        else
            text.replace(at, 1, std::string(1, static_cast<char>(*rc::gen::inRange(0, 256))));
        if (text.empty()) break;
    }
    auto other = project();
    const auto recalled = recall(text, kNow, 0, other);
    RC_ASSERT(recalled.whole || recalled.findings.size() == 1);
}

TEST(Learnt, EachFindingHasItsTexts) {
    for (const auto language : text::kLanguages)
        for (const auto* code : {"learnt.damaged", "learnt.late", "learnt.stale", "learnt.unreadable"})
            for (const auto& key : {std::string(code), std::string(code) + ".advice"})
                EXPECT_TRUE(text::has(language, key)) << key;
}

// Lines that accept such lengths, and those without a header, are not named.
TEST(Learnt, NamesLinesWhoseLengthsAreOff) {
    auto tcp = project();
    tcp.lines[0].framing = wire::Framing::tcp;
    const auto text = learnt_text(tcp, known(), {}, kNow, {true});
    const auto recalled = recall(text, kNow, 0, tcp);
    EXPECT_TRUE(recalled.whole);
    ASSERT_EQ(recalled.findings.size(), 1U);
    EXPECT_EQ(recalled.findings[0].code, "learnt.lengths_off");
    EXPECT_EQ(recalled.findings[0].path, "lines[0]");
    tcp.lines[0].length_tolerance = true;
    EXPECT_TRUE(recall(text, kNow, 0, tcp).findings.empty());
    auto serial = project();
    EXPECT_TRUE(recall(text, kNow, 0, serial).findings.empty());
    auto bad = text;
    bad.replace(bad.find("\"lengths_off\": true"), 19, "\"lengths_off\": 1");
    EXPECT_EQ(recall(bad, kNow, 0, tcp).findings[0].value, "lines[0].lengths_off");
}

}  // namespace learnt_test
}  // namespace takt::file
