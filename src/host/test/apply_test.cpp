// Another project replaces the running one: unchanged parts continue undisturbed.
#include <gtest/gtest.h>

#include <string>

#include "projects.hpp"
#include "rig.hpp"

namespace takt::host::test {
namespace apply_test {

using value::CommandResult;
using value::Quality;

poll::DeviceStatistics device(const Rig& rig, std::size_t line, std::size_t index) {
    return rig.engine->master().line(line).device(index);
}

TEST(Apply, TheSameProjectGoesOnAsIfNothingHadHappened) {
    const auto yaml = project_with(line_of("main", boiler() + pump()));
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
    Rig rig(project_with(line_of("main", boiler())));
    rig.run(1s);
    const auto before = rig.engine->master().store()[rig.slot("Level")];
    ASSERT_EQ(before.quality, Quality::good);
    // Another line and a local come before it: its slot has another number.
    rig.apply(
        project_with(line_of("first", pump()) + line_of("main", boiler()), "  - {name: go, type: bool}\n"));
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
    Rig rig(project_with(line_of("main", boiler())));
    rig.run(1s);
    rig.apply(project_with(line_of("main", boiler(variable_of("Limit", 10, ", period: 1h")))));
    rig.run(50ms);
    EXPECT_EQ(rig.engine->master().store()[rig.slot("Limit")].quality, Quality::good);
}

TEST(Apply, WhatWasSetAndNotWrittenYetIsWrittenByTheNewProject) {
    const auto yaml = project_with(line_of("main", boiler()));
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
    const auto yaml = project_with(line_of("main", boiler()));
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
    Rig rig(project_with(line_of("main", boiler() + pump())));
    rig.run(500ms);
    rig.apply(project_with(line_of("main", pump())));
    EXPECT_FALSE(rig.engine->configuration()->find("Level"));
    rig.run(500ms);
    EXPECT_EQ(device(rig, 0, 0).state, poll::DeviceState::answering);
    EXPECT_EQ(rig.engine->master().store()[rig.slot("Speed")].quality, Quality::good);
}

}  // namespace apply_test
}  // namespace takt::host::test
