// The state of a running project, as JSON and as the text made of it.
#include "takt/report/states/state_report.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "host_sample.hpp"
#include "takt/report/drawing/text_table.hpp"

namespace takt::report {
namespace state_report_test {

using namespace test;
using namespace std::chrono_literals;
using value::Quality;
using value::Reason;

constexpr const char* kTime = "2026-11-23T02:03:04.005+00:00";

/// The line is up, its device answers, every value was read.
host::Snapshot healthy() {
    auto made = snapshot_of(plant());
    made.lines[0].up = made.lines[0].was_up = true;
    made.lines[0].statistics.recent_utilization = 0.125;
    made.lines[0].statistics.planned_cycle = 100ms;
    made.lines[0].statistics.measured_cycle = 105ms;
    made.lines[0].devices[0].state = poll::DeviceState::answering;
    for (auto& slot : made.values) slot = {.quality = Quality::good, .sampled_at = made.t - 1500ms};
    made.values[slot_of("Level").value].value = std::int64_t{17};
    return made;
}

std::string health(const host::Snapshot& snapshot) {
    return std::get<std::string>(status_json(english(), snapshot, kTime).find("health")->value());
}

TEST(StateReport, ADeviceWhoseResponsesMayBeThoseToOtherRequestsIsTrouble) {
    auto shifted = healthy();
    shifted.lines[0].devices[0].shifted = true;
    EXPECT_EQ(health(shifted), "degraded");
}

TEST(StateReport, StatusHasHealthLoadCycleAndStates) {
    const auto json = status_json(english(), healthy(), kTime);
    const auto& line = std::get<file::Json::Array>(json.find("lines")->value())[0];
    EXPECT_JSON(*json.find("time"), kTime);
    EXPECT_JSON(*json.find("health"), "ok");
    EXPECT_JSON(*json.find("uptime_ms"), 10000.0);
    EXPECT_EQ(json.find("values")->dump(), R"({"good":5,"uncertain":0,"bad":0,"never_read":0})");
    EXPECT_JSON(*line.find("state"), "connected");
    EXPECT_JSON(*line.find("load"), 0.125);
    EXPECT_JSON(*line.find("measured_cycle_ms"), 105.0);
    const auto& device = std::get<file::Json::Array>(line.find("devices")->value())[0];
    EXPECT_JSON(*device.find("state"), "answering");
    EXPECT_TRUE(device.find("response_ms")->is_null()) << "nothing was answered";
    for (const auto language : kLanguages) {
        const auto text = status_text(Texts(language), json);
        expect_complete(text);
        expect_contains(text, "12.5 %");
        expect_contains(text, Texts(language).duration(105ms));
        expect_contains(text, "Котёл");
        expect_contains(text, Texts(language)("app.health.ok"));
    }
}

TEST(StateReport, StatusHasAvailabilityAndLateAnswers) {
    auto snapshot = healthy();
    auto& device = snapshot.lines[0].devices[0];
    device.availability.begin(snapshot.started);
    device.availability.up(snapshot.started);
    device.availability.down(snapshot.t - 1s);
    device.late = 3;
    device.delays = {poll::DelayFinding::Setting::response_timeout, 148ms, 100ms, 300ms, 9};
    device.noise = poll::NoiseFinding{.least = 1, .most = 2};
    snapshot.lines[0].times[0] = {
        .exchanges = 3120, .longest = 7600us, .p999 = 7100us, .attempts = 3123, .late = 3, .lateness = 148ms};
    const auto json = status_json(english(), snapshot, kTime);
    const auto& line = std::get<file::Json::Array>(json.find("lines")->value())[0];
    EXPECT_TRUE(line.find("availability_percent")->is_null());
    const auto& shown = std::get<file::Json::Array>(line.find("devices")->value())[0];
    EXPECT_JSON(*shown.find("availability_percent"), 90.0);
    EXPECT_JSON(*shown.find("downtime_ms"), 1000.0);
    EXPECT_JSON(*shown.find("late_answers"), 3);
    EXPECT_JSON(*shown.find("delays")->find("advised_ms"), 300.0);
    EXPECT_JSON(*shown.find("turnaround")->find("exchanges"), 3120);
    EXPECT_JSON(*shown.find("late_responses")->find("count"), 3);
    const auto text = status_text(english(), json);
    expect_contains(text, "90.00 %");
    expect_contains(
        text,
        "  note: Device Котёл answered 148 ms after its request; response_timeout is 100 ms: set 300ms\n"
        "  note: 1..2 bytes of noise before the answers of Котёл: check bias and driver enable\n");
    EXPECT_EQ(text.find("1..2 bytes of noise"), text.rfind("1..2 bytes of noise")) << "once";
    expect_contains(text, "  Котёл: 3 late responses to 3123 requests, the latest after 148 ms\n");
    EXPECT_JSON(*shown.find("noise")->find("most_bytes"), 2);
}

// Nothing answers there: neither an answer nor its time is missing.
TEST(StateReport, BroadcastsAreNeverAnswered) {
    auto project = plant()->project();
    project.lines[0].framing = wire::Framing::rtu;
    project.lines[0].devices[0].address = kBroadcast;
    auto snapshot = healthy();
    snapshot.configuration = configuration_of(project);
    auto& availability = snapshot.lines[0].devices[0].availability;
    availability.begin(snapshot.started);
    availability.up(snapshot.started);
    const auto json = status_json(english(), snapshot, kTime);
    const auto& line = std::get<file::Json::Array>(json.find("lines")->value())[0];
    const auto& device = std::get<file::Json::Array>(line.find("devices")->value())[0];
    EXPECT_JSON(*device.find("broadcast"), true);
    EXPECT_TRUE(device.find("availability_percent")->is_null());
    const auto text = status_text(english(), json);
    expect_contains(text, "broadcasts, never answered");
    EXPECT_EQ(text.find("answering"), std::string::npos) << text;
}

TEST(StateReport, HealthFollowsWhatIsWrong) {
    EXPECT_EQ(health(healthy()), "ok");
    auto snapshot = healthy();
    snapshot.values[slot_of("Level").value].quality = Quality::never_read;
    EXPECT_EQ(health(snapshot), "ok") << "what is only read by a trigger is no trouble";
    snapshot.values[slot_of("Level").value].quality = Quality::uncertain;
    EXPECT_EQ(health(snapshot), "degraded");
    snapshot = healthy();
    snapshot.lines[0].requests[0].overrun = true;
    EXPECT_EQ(health(snapshot), "ok") << "it was not sent lately";
    snapshot.lines[0].requests[0].recent_period = 900ms;
    EXPECT_EQ(health(snapshot), "degraded");
    snapshot = healthy();
    snapshot.lines[0].devices[0].state = poll::DeviceState::not_answering;
    EXPECT_EQ(health(snapshot), "failed");
    snapshot.lines[0].devices[0].state = poll::DeviceState::switched_off;
    EXPECT_EQ(health(snapshot), "ok");
}

TEST(StateReport, ALineThatWasNeverConnectedIsNotLost) {
    auto snapshot = healthy();
    snapshot.lines[0].up = snapshot.lines[0].was_up = false;
    snapshot.lines[0].devices[0].state = poll::DeviceState::link_down;
    snapshot.lines[0].why = fail(Code::cannot_open, "/dev/ttyUSB0", ENOENT).error();
    EXPECT_EQ(link_word(snapshot.lines[0]), "never_connected");
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = status_text(texts, status_json(texts, snapshot, kTime));
        expect_contains(text, texts("app.link.never_connected"));
        expect_contains(text, "/dev/ttyUSB0");
        EXPECT_EQ(text.find(texts("app.link.lost")), std::string::npos) << text;
    }
    snapshot.lines[0].was_up = true;
    EXPECT_EQ(link_word(snapshot.lines[0]), "lost");
}

TEST(StateReport, ValuesHaveUnitAgeQualityAndReason) {
    auto snapshot = healthy();
    auto& speed = snapshot.values[slot_of("Speed").value];
    speed = {.value = 2.5,
             .quality = Quality::bad,
             .reason = value::exception_reason(2),
             .sampled_at = snapshot.t - 200s};
    const auto json = values_json(snapshot, kTime, "");
    const auto& values = std::get<file::Json::Array>(json.find("values")->value());
    ASSERT_EQ(values.size(), 5U);
    EXPECT_EQ(values[slot_of("Level").value].dump(),
              R"({"name":"Level","line":"main","device":"Котёл","value":17,"text":"17","unit":"мм",)"
              R"("quality":"good","reason":"","age_ms":1500.0})");
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = values_text(texts, json);
        expect_complete(text);
        expect_contains(text, "17 мм");
        expect_contains(text, texts.duration(1500ms));
        expect_contains(text, texts.duration(200s));
        expect_contains(text, texts.quality(Quality::bad, value::exception_reason(2)));
    }
    EXPECT_EQ(
        std::get<file::Json::Array>(values_json(snapshot, kTime, "?evel").find("values")->value()).size(),
        1U);
}

TEST(StateReport, ADeviceThatDoesNotAnswerHasACause) {
    auto snapshot = healthy();
    snapshot.lines[0].devices[0].state = poll::DeviceState::not_answering;
    snapshot.lines[0].devices[0].failure = Reason::bad_checksum;
    snapshot.values[slot_of("Level").value] = {.quality = Quality::bad, .reason = Reason::not_answering};
    expect_contains(values_text(english(), values_json(snapshot, kTime, "Level")), "(damaged response)");
    expect_contains(status_text(english(), status_json(english(), snapshot, kTime)), "answers are damaged");
    snapshot.lines[0].devices[0].failure = Reason::timeout;
    expect_contains(status_text(english(), status_json(english(), snapshot, kTime)),
                    "not answering (time-out)");
}

TEST(StateReport, GetHasTheKeysOfAnEntryOfValues) {
    host::Outcome outcome{.kind = host::Command::Kind::get, .slot = slot_of("Level"), .t = Instant{11s}};
    outcome.value = std::int64_t{17};
    outcome.sampled_at = Instant{10s};
    EXPECT_EQ(get_json(*plant(), outcome).dump(),
              R"({"event":"answer","command":"get","name":"Level","line":"main","device":"Котёл","value":17,)"
              R"("text":"17","unit":"мм","quality":"good","reason":"","age_ms":1000.0})");
    EXPECT_EQ(get_line(get_json(*plant(), outcome)), "ok Level 17");
    outcome.quality = Quality::never_read;
    outcome.reason = Reason::never_connected;
    outcome.value = {};
    EXPECT_EQ(get_line(get_json(*plant(), outcome)), "ok Level never_read never_connected");
}

TEST(StateReport, ListHasWhatIsKnownBeforeTheFirstRead) {
    const auto json = list_json(*plant());
    const auto& names = std::get<file::Json::Array>(json.find("names")->value());
    ASSERT_EQ(names.size(), 5U);
    EXPECT_EQ(names[slot_of("Level").value].dump(),
              R"({"name":"Level","line":"main","device":"Котёл","type":"int16","unit":"мм","readable":true,)"
              R"("writable":true})");
    for (const auto language : kLanguages) expect_contains(list_text(Texts(language), json), "go");
}

std::size_t longest_line(const std::string& text) {
    std::size_t longest = 0;
    for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1)
        longest = std::max(longest, display_width(text.substr(at, text.find('\n', at) - at)));
    return longest;
}

TEST(StateReport, TablesFitTheTerminal) {
    const auto json = *file::Json::parse(
        R"({"names":[{"name":"Level","device":"The controller of the boiler in the second cellar, left",)"
        R"("type":"string",)"
        R"("unit":"kWh","readable":true,"writable":true}],)"
        R"("values":[{"name":"Level","device":"The controller of the boiler in the second cellar",)"
        R"("quality":"good",)"
        R"("text":"a text that is longer than a third of the line","age_ms":20}]})");
    for (const auto language : kLanguages) {
        const Texts texts(language);
        for (const auto& text : {list_text(texts, json, 80), values_text(texts, json, 80)}) {
            EXPECT_LE(longest_line(text), 80U) << text;
            expect_contains(text, "Level");
            expect_contains(text, "…");
        }
        EXPECT_EQ(list_text(texts, json).find("…"), std::string::npos) << "no terminal";
        EXPECT_EQ(values_text(texts, json).find("…"), std::string::npos) << "no terminal";
    }
}

// ctl reads what a socket sends.
TEST(StateReport, MissingAndWrongKeysAreLeftOut) {
    const char* const texts[] = {"{}", "[]", "null",
                                 R"({"lines":[1,{}],"values":[3,{"age_ms":"x"}],"names":[{}]})",
                                 R"({"uptime_ms":1e300,"lines":{"a":1},"values":{"good":-1}})"};
    for (const auto* text : texts) {
        const auto json = *file::Json::parse(text);
        for (const auto& made :
             {status_text(english(), json), values_text(english(), json), list_text(english(), json)})
            EXPECT_TRUE(made.ends_with('\n')) << text;
        EXPECT_EQ(get_line(json), "ok");
    }
}

TEST(StateReport, PatternsOfNames) {
    const struct {
        const char* pattern;
        const char* name;
        bool matches;
    } cases[] = {{"", "Level", true},      {"eve", "Level", true},   {"level", "Level", false},
                 {"*", "", true},          {"L*l", "Level", true},   {"L*l", "Levels", false},
                 {"L???l", "Level", true}, {"L??l", "Level", false}, {"*e*e*", "Level", true},
                 {"*a*", "Level", false},  {"?", "", false},         {"a**b", "ab", true},
                 {"Те?п", "Темп", true},   {"Те??п", "Темп", false}};
    for (const auto& [pattern, name, matches] : cases)
        EXPECT_EQ(name_matches(pattern, name), matches) << pattern << ' ' << name;
}

}  // namespace state_report_test
}  // namespace takt::report
