// Another project takes the place of the running one: what did not change goes on undisturbed.
#include <gtest/gtest.h>

#include <string>

#include "rig.hpp"

namespace takt::host::test {
namespace {

using value::CommandResult;
using value::Quality;

std::string line_of(const std::string& name, const std::string& devices) {
    return "  - name: " + name + "\n    transport: simulated\n    framing: rtu\n    baud: 19200\n    devices:\n" +
           devices;
}

std::string device_of(const std::string& name, int address, const std::string& variables) {
    return "      - name: " + name + "\n        address: " + std::to_string(address) +
           "\n        poll_period: 100ms\n        turnaround: 5ms\n        variables:\n" + variables;
}

std::string variable_of(const std::string& name, int place, const std::string& more = "") {
    return "          - {name: " + name + ", type: int, register: " + std::to_string(place) + ", read: 0x03" + more +
           "}\n";
}

const std::string kWritten = ", write: 0x10, write_on_change: true";
const std::string kBoiler = device_of("Boiler", 1, variable_of("Level", 0) + variable_of("Setpoint", 10, kWritten));
const std::string kPump = device_of("Pump", 2, variable_of("Speed", 0));

std::string project_with(const std::string& lines, const std::string& locals = "") {
    return "takt: 1\nlines:\n" + lines + (locals.empty() ? "" : "locals:\n" + locals);
}

const poll::DeviceStatistics& device(const Rig& rig, std::size_t line, std::size_t index) {
    return rig.engine->master().line(line).device(index);
}

TEST(Apply, TheSameProjectGoesOnAsIfNothingHadHappened) {
    const auto yaml = project_with(line_of("main", kBoiler + kPump));
    Rig rig(yaml);
    const auto session = rig.open();
    rig.run(1s);
    const auto answered = device(rig, 0, 0).counters.answered;
    (void)take_events(*session);
    rig.apply(yaml);
    EXPECT_GE(device(rig, 0, 0).counters.answered, answered);
    EXPECT_LE(device(rig, 0, 0).counters.answered, answered + 1) << "at most the one in flight";
    EXPECT_EQ(device(rig, 0, 0).state, poll::DeviceState::answering);
    rig.run(1s);
    EXPECT_GE(device(rig, 0, 0).counters.answered, answered + 18);
    EXPECT_EQ(device(rig, 0, 0).counters.sent, device(rig, 0, 0).counters.answered);
    for (const auto& event : take_events(*session)) {
        EXPECT_FALSE(std::holds_alternative<DeviceStateChanged>(event.body));
        EXPECT_FALSE(std::holds_alternative<LinkChanged>(event.body));
        EXPECT_FALSE(std::holds_alternative<PeriodOverrun>(event.body));
        const auto* const changed = std::get_if<ValueChanged>(&event.body);
        EXPECT_TRUE(!changed || changed->quality == Quality::good);
    }
    EXPECT_EQ(session->configuration()->generation(), 2U);
}

TEST(Apply, ValuesKeepTheirQualityAndAgeWhereverTheyMoveTo) {
    Rig rig(project_with(line_of("main", kBoiler)));
    rig.run(1s);
    const auto before = rig.engine->master().store()[rig.slot("Level")];
    ASSERT_EQ(before.quality, Quality::good);
    // Another line and a local come before it: its slot has another number.
    rig.apply(project_with(line_of("first", kPump) + line_of("main", kBoiler), "  - {name: go, type: bool}\n"));
    const auto& after = rig.engine->master().store()[rig.slot("Level")];
    EXPECT_EQ(after.quality, Quality::good);
    ASSERT_TRUE(after.good_at && before.good_at);
    EXPECT_GE(*after.good_at, *before.good_at);
    EXPECT_LE(*after.good_at, *before.good_at + 200ms) << "not read anew by the new line";
    rig.run(500ms);
    EXPECT_EQ(rig.engine->master().store()[rig.slot("Speed")].quality, Quality::good);
    EXPECT_GT(device(rig, 1, 0).counters.answered, 20U) << "counted from before";
}

TEST(Apply, ANewVariableOfARunningDeviceIsReadAtOnce) {
    Rig rig(project_with(line_of("main", kBoiler)));
    rig.run(1s);
    const auto grown = device_of("Boiler", 1,
                                 variable_of("Level", 0) + variable_of("Setpoint", 10, kWritten) +
                                     variable_of("Limit", 10, ", period: 1h"));
    rig.apply(project_with(line_of("main", grown)));
    rig.run(50ms);
    EXPECT_EQ(rig.engine->master().store()[rig.slot("Limit")].quality, Quality::good);
}

TEST(Apply, WhatWasSetAndNotWrittenYetIsWrittenByTheNewProject) {
    const auto yaml = project_with(line_of("main", kBoiler));
    Rig rig(yaml);
    rig.run(500ms);
    rig.devices(0).find(UnitId{1})->behaviour.dead = true;
    rig.run(3s);
    const auto session = rig.open();
    ASSERT_TRUE(session->submit({Command::Kind::set, rig.slot("Setpoint"), std::int64_t{42}}));
    rig.serve();
    rig.apply(yaml);
    const auto outcome = session->next_outcome();
    ASSERT_TRUE(outcome);
    EXPECT_EQ(outcome->progress, Outcome::Progress::waiting);
    EXPECT_EQ(device(rig, 0, 0).state, poll::DeviceState::not_answering) << "health is kept";
    rig.devices(0).find(UnitId{1})->behaviour.dead = false;
    rig.run(70s);  // the longest back-off
    EXPECT_TRUE(value::same(rig.engine->master().store()[rig.slot("Setpoint")].value, std::int64_t{42}));
}

TEST(Apply, CommandsEndBeforeTheSwitchAndLaterOnesBelongToTheNewProject) {
    const auto yaml = project_with(line_of("main", kBoiler));
    Rig rig(yaml);
    rig.run(500ms);
    const auto session = rig.open();
    ASSERT_TRUE(session->submit({Command::Kind::write, rig.slot("Setpoint"), std::int64_t{7}}));
    rig.serve();
    rig.apply(yaml);
    const auto outcome = session->next_outcome();
    ASSERT_TRUE(outcome);
    EXPECT_EQ(outcome->result, CommandResult::done);
    // The session still has the old configuration: the host cannot know which variable it means.
    ASSERT_TRUE(session->submit({Command::Kind::write, rig.slot("Setpoint"), std::int64_t{8}}));
    rig.serve();
    const auto refused = session->next_outcome();
    ASSERT_TRUE(refused && refused->error);
    (void)take_events(*session);
    ASSERT_TRUE(session->submit({Command::Kind::write, rig.slot("Setpoint"), std::int64_t{9}}));
    rig.run(300ms);
    const auto done = session->next_outcome();
    ASSERT_TRUE(done);
    EXPECT_EQ(done->result, CommandResult::done);
}

TEST(Apply, ARemovedDeviceIsNotAskedAnyMore) {
    Rig rig(project_with(line_of("main", kBoiler + kPump)));
    rig.run(500ms);
    rig.apply(project_with(line_of("main", kPump)));
    EXPECT_FALSE(rig.engine->configuration()->find("Level"));
    rig.run(500ms);
    EXPECT_EQ(device(rig, 0, 0).state, poll::DeviceState::answering);
    EXPECT_EQ(rig.engine->master().store()[rig.slot("Speed")].quality, Quality::good);
}

}  // namespace
}  // namespace takt::host::test
