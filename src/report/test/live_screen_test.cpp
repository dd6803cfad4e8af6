// The live display at the sizes of real terminals.
#include "takt/report/states/live_screen.hpp"

#include <gtest/gtest.h>

#include "host_sample.hpp"
#include "takt/report/drawing/text_table.hpp"

namespace takt::report {
namespace live_screen_test {

using namespace test;
using namespace std::chrono_literals;
using poll::DeviceState;
using value::Quality;
using value::Reason;

host::Snapshot healthy(const host::ConfigurationPtr& configuration = plant()) {
    auto made = snapshot_of(configuration);
    for (auto& slot : made.values) slot = {.quality = Quality::good, .sampled_at = made.t - 100ms};
    for (auto& line : made.lines) {
        line.up = line.was_up = true;
        line.statistics.recent_utilization = 0.5;
        for (auto& device : line.devices) device.state = DeviceState::answering;
    }
    return made;
}

/// Devices D1, D2, … on lines L1, L2, …, each with `values` values.
host::ConfigurationPtr large(std::size_t lines, std::size_t devices, std::size_t values) {
    std::string yaml = "takt: 1\nlines:\n";
    for (std::size_t l = 1; l <= lines; ++l) {
        yaml += "  - {name: L" + std::to_string(l) + ", transport: simulated, framing: rtu, devices: [";
        for (std::size_t d = 1; d <= devices; ++d) {
            const auto number = std::to_string((l - 1) * devices + d);
            yaml += "{name: D" + number + ", address: " + std::to_string(d) + ", variables: [";
            for (std::size_t v = 0; v < values; ++v)
                yaml += "{name: V" + number + '_' + std::to_string(v) +
                        ", type: int16, register: " + std::to_string(v) + ", read: 0x03},";
            yaml += "]},";
        }
        yaml += "]}\n";
    }
    return configuration_of(project_of(yaml));
}

std::string joined(const std::vector<std::string>& lines) {
    std::string text;
    for (const auto& line : lines) text += line + '\n';
    return text;
}

TEST(LiveScreen, HasLinesDevicesAndValuesInEveryLanguage) {
    for (const auto language : kLanguages) {
        const Texts texts(language);
        LiveSelection selection;
        const auto lines = live_screen(texts, healthy(), selection, {24, 80});
        ASSERT_EQ(lines.size(), 8U) << joined(lines);
        expect_contains(lines[0], "main");
        expect_contains(lines[0], "50.0 %");
        EXPECT_EQ(lines[1], "  " + texts("app.state.answering") + ": Котёл");
        expect_contains(lines[2], texts("app.variable"));
        for (const auto& line : lines) {
            expect_complete(line);
            EXPECT_LT(display_width(line), 80U) << line;
        }
    }
}

TEST(LiveScreen, ResponseTimesAreBelowTheDevicesWhereTheyFit) {
    auto snapshot = healthy();
    auto& times = snapshot.lines[0].times[0];
    times = {.exchanges = 12, .longest = 7600us};
    for (const auto language : kLanguages) {
        const Texts texts(language);
        LiveSelection selection;
        const auto turnaround =
            texts("app.live.turnaround", {{"devices", "Котёл " + texts.duration(7600us)}});
        times.late = 0;
        EXPECT_EQ(live_screen(texts, snapshot, selection, {24, 80})[2], "  " + turnaround);
        times.late = 3;
        times.lateness = 412ms;
        const auto one = texts("app.live.late.device",
                               {{"device", "Котёл"}, {"late", "3"}, {"lateness", texts.duration(412ms)}});
        const auto lines = live_screen(texts, snapshot, selection, {24, 80});
        EXPECT_EQ(lines[2], "  " + texts("app.live.late", {{"devices", one}}) + "; " + turnaround);
        for (const auto& line : lines) expect_complete(line);
        expect_contains(live_screen(texts, snapshot, selection, {7, 80})[2], texts("app.variable"));
    }
    LiveSelection selection;
    const auto measured = times;
    snapshot = healthy(large(4, 1, 1));
    for (auto& line : snapshot.lines) line.times[0] = measured;
    EXPECT_EQ(joined(live_screen(english(), snapshot, selection, {24, 80})).find("turnaround"),
              std::string::npos)
        << "four lines have no room for them";
}

TEST(LiveScreen, WhatIsNotGoodIsAtTheTopAndReadable) {
    auto snapshot = healthy();
    snapshot.values[slot_of("Pump").value] = {.quality = Quality::never_read};
    snapshot.values[slot_of("Tag").value] = {.value = std::string("a text"),
                                             .quality = Quality::bad,
                                             .reason = value::exception_reason(2),
                                             .sampled_at = snapshot.t - 200s};
    LiveSelection selection;
    const auto lines = live_screen(english(), snapshot, selection, {24, 80});
    expect_contains(lines[2], "warning: Котёл: bad, exception 2");
    expect_contains(lines[4], "Tag");
    EXPECT_TRUE(lines[4].ends_with("3 min 20 s  bad, exception 2")) << lines[4];
    expect_contains(lines[5], "Pump");
    expect_contains(lines[5], "no value yet");
}

TEST(LiveScreen, AProblemHasWhatIsTriedAndTheNextStep) {
    auto snapshot = healthy();
    auto& device = snapshot.lines[0].devices[0];
    device.state = DeviceState::not_answering;
    device.failure = Reason::timeout;
    device.back_off = 8s;
    LiveSelection selection;
    const auto lines = live_screen(english(), snapshot, selection, {24, 80});
    expect_contains(lines[2], "error: Котёл: no answer within");
    expect_contains(lines[3], "    After 3 failed attempts the device is only probed");
    expect_contains(lines[4], "    Check the unit address");
    for (const auto& line : lines) EXPECT_LT(display_width(line), 80U) << line;
    const auto small = live_screen(english(), snapshot, selection, {11, 80});
    expect_contains(small[2], "error: Котёл: no answer within");
    expect_contains(small[3], "After 3 failed attempts");
    expect_contains(small[4], "variable");
}

TEST(LiveScreen, ARowForEachKindOfValue) {
    auto snapshot = healthy();
    snapshot.values[slot_of("Level").value] = {
        .value = std::int64_t{17}, .quality = Quality::good, .sampled_at = snapshot.t - 1500ms};
    snapshot.values[slot_of("Tag").value] = {
        .value = kHostile, .quality = Quality::good, .sampled_at = snapshot.t + 1s};
    snapshot.values[slot_of("Pump").value] = {};
    snapshot.values[slot_of("go").value] = {
        .value = true, .quality = Quality::good, .sampled_at = snapshot.t};
    LiveSelection selection;
    for (const auto language : kLanguages) {
        const Texts texts(language);
        std::string text;
        for (const auto& line : live_screen(texts, snapshot, selection, {24, 100})) {
            for (const char c : line)
                if (c != ' ' || !text.ends_with(' ')) text += c;
            text += '\n';
        }
        expect_contains(text, "Котёл Level 17 мм " + texts.duration(1500ms) + "\n");
        expect_contains(text, "Котёл Pump – " + texts.quality(Quality::never_read, Reason::ok));
        expect_contains(
            text, "Котёл Tag " + kHostileLine + " " + texts.duration(0s) + "\n");  // an age is never negative
        expect_contains(text, "\n go true\n");  // a local has no device and no age
    }
}

TEST(LiveScreen, ALineWithoutALinkIsNamed) {
    auto snapshot = healthy();
    snapshot.lines[0].up = snapshot.lines[0].was_up = false;
    snapshot.lines[0].devices[0].state = DeviceState::link_down;
    LiveSelection selection;
    expect_contains(live_screen(english(), snapshot, selection, {24, 80})[0], "never connected");
    snapshot.lines[0].was_up = true;
    expect_contains(live_screen(english(), snapshot, selection, {24, 80})[0], "connection lost");
}

TEST(LiveScreen, FitsEveryScreen) {
    const auto configuration = large(12, 3, 20);
    auto snapshot = healthy(configuration);
    snapshot.lines[7].devices[1].state = DeviceState::not_answering;
    for (const std::size_t rows : {1U, 5U, 10U, 24U, 50U, 1000U})
        for (const std::size_t columns : {20U, 80U, 200U}) {
            LiveSelection selection{.takes_keys = true};
            const auto lines = live_screen(english(), snapshot, selection, {rows, columns});
            EXPECT_LT(lines.size(), std::max<std::size_t>(rows, 6)) << rows;
            if (rows >= 10) expect_contains(lines[0], "L8");
        }
}

TEST(LiveScreen, PagesAndCounts) {
    const auto configuration = large(1, 2, 30);
    const auto snapshot = healthy(configuration);
    LiveSelection selection{.takes_keys = true, .has_devices = true};
    auto lines = live_screen(english(), snapshot, selection, {24, 80});
    EXPECT_EQ(lines.size(), 23U);
    expect_contains(lines.back(),
                    english()("app.live.rows", {{"first", "1"}, {"last", "19"}, {"all", "60"}}));
    EXPECT_LT(display_width(lines.back()), 80U) << lines.back();
    selection.first = 1000;
    lines = live_screen(english(), snapshot, selection, {24, 80});
    EXPECT_EQ(selection.first, 41U);
    expect_contains(lines[lines.size() - 2], "V2_29");
}

TEST(LiveScreen, SelectsByDeviceNameAndQuality) {
    const auto configuration = large(1, 2, 30);
    auto snapshot = healthy(configuration);
    snapshot.values[configuration->find("V2_7")->value].quality = Quality::bad;
    LiveSelection selection{.device = "D2"};
    auto text = joined(live_screen(english(), snapshot, selection, {50, 80}));
    EXPECT_EQ(text.find("V1_"), std::string::npos);
    expect_contains(text, "V2_29");
    selection = {.filter = "V?_2"};
    text = joined(live_screen(english(), snapshot, selection, {50, 80}));
    expect_contains(text, "V1_2 ");
    EXPECT_EQ(text.find("V1_20"), std::string::npos);
    selection = {.not_good = true};
    text = joined(live_screen(english(), snapshot, selection, {50, 80}));
    expect_contains(text, "V2_7");
    EXPECT_EQ(text.find("V2_8"), std::string::npos);
}

TEST(LiveScreen, TheLastLineShowsTheFilterThatIsTyped) {
    LiveSelection selection{.filter = "Le", .typing = true, .takes_keys = true};
    expect_contains(live_screen(english(), healthy(), selection, {24, 80}).back(), "Le");
}

}  // namespace live_screen_test
}  // namespace takt::report
