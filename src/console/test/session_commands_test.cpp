// Lines of text to a host's engine in virtual time.
#include "takt/console/session_commands.hpp"

#include <gtest/gtest.h>

#include "support.hpp"

namespace takt::console {
namespace session_commands_test {

using namespace test;

class SessionCommandsTest : public testing::Test {
protected:
    SessionCommandsTest()
        : session(rig.open()),
          commands(
              *session, [this] { quit = true; },
              [this](const host::SnapshotParts& parts) {
                  return Result<host::Snapshot>(rig.snapshot(parts)->snapshot);
              }) {
        rig.run(300ms);
    }

    /// The answer to a line, after the host has had its time.
    std::string answer(const std::string& line) {
        Answers answers;
        const auto done = commands.execute(line, answers.reply(), english());
        if (!done) return std::string(name(done.error().code));
        if (answers.lines.empty()) rig.run(300ms);
        commands.take_outcomes();
        EXPECT_EQ(answers.lines.size(), 1U) << line;
        return answers.lines.empty() ? "" : answers.lines[0];
    }

    host::test::Rig rig{kPlant};
    std::unique_ptr<host::Session> session;
    bool quit = false;
    SessionCommands commands;
};

TEST_F(SessionCommandsTest, WritesAndReadsBack) {
    EXPECT_EQ(answer("write Level 42"), "done Level\n");
    EXPECT_EQ(answer("get Level"), "ok Level 42\n");
    EXPECT_EQ(answer("write \"Pump speed\" 1.5"), "done Pump speed\n");
    EXPECT_EQ(answer("get \"Pump speed\""), "ok Pump speed 1.5\n");
    EXPECT_EQ(answer("set go true"), "ok go true\n");
}

TEST_F(SessionCommandsTest, AnswersWhatIsNoVariableOrNoValue) {
    for (const std::string line : {"get Xyz", "write Xyz 1", "set Xyz 1"})
        EXPECT_EQ(answer(line),
                  "error not_found Xyz: no such name among 3; `list` shows all, `values PATTERN` those that "
                  "match\n");
    EXPECT_EQ(answer("get Levl"), "error not_found Levl: no such name, nearest: Level; `list` shows all\n");
    EXPECT_EQ(answer("write levl 1"),
              "error not_found levl: no such name, nearest: Level; `list` shows all\n");
    EXPECT_EQ(
        answer("statsu"),
        "error syntax statsu: no such command, nearest: status; allowed: status, list, values [PATTERN], "
        "get NAME, set NAME VALUE, write NAME VALUE, quit\n");
    EXPECT_TRUE(answer("write Level many").starts_with("error "));
    EXPECT_TRUE(answer("write Level 70000").starts_with("error "));
    EXPECT_TRUE(answer("erase Level").starts_with("error syntax erase: no such command, allowed: status, "));
}

TEST_F(SessionCommandsTest, ServiceVariablesCanBeReadOnly) {
    EXPECT_EQ(answer("get system.pulse_1s"), "ok system.pulse_1s false\n");
    EXPECT_EQ(answer("set system.uptime 5"),
              "error read_only system.uptime: read-only: the program itself provides this value\n");
    EXPECT_EQ(answer("write system.uptime many"), answer("set system.uptime 5"));
    EXPECT_EQ(answer("get system.uptme"),
              "error not_found system.uptme: no such service variable, nearest: system.uptime; allowed: "
              "system.time, system.uptime, system.first_cycle, system.pulse_1s, system.pulse_1min, "
              "system.line.NAME.*, system.device.NAME.*\n");
}

TEST_F(SessionCommandsTest, AMistypedServiceVariableListsWhatExists) {
    EXPECT_NE(answer("get system").find("system.line.NAME.*"), std::string::npos);
    EXPECT_NE(answer("get sytem.uptime").find("nearest: system.uptime"), std::string::npos);
    EXPECT_EQ(answer("get pump.speed"),
              "error not_found pump.speed: no such name, nearest: Pump speed; `list` shows all\n");
}

TEST_F(SessionCommandsTest, GivesEachOutcomeToTheOneWhoAsked) {
    Answers first;
    Answers second;
    ASSERT_TRUE(commands.execute("write Level 1", first.reply(), english()));
    ASSERT_TRUE(commands.execute("get go", second.reply(), english()));
    ASSERT_TRUE(commands.execute("get Level", first.reply(), english()));
    EXPECT_TRUE(first.lines.empty());
    rig.run(500ms);
    commands.take_outcomes();
    EXPECT_EQ(first.lines.size(), 2U);
    EXPECT_EQ(second.lines, std::vector<std::string>{"ok go false\n"});
}

TEST_F(SessionCommandsTest, AnswersTheStateOfTheProject) {
    EXPECT_EQ(answer("write Level 42"), "done Level\n");
    rig.run(300ms);
    const auto status = file::Json::parse(answer("status"));
    ASSERT_TRUE(status);
    EXPECT_EQ(*status->find("health"), file::Json("ok"));
    const auto values = file::Json::parse(answer("values Lev*"));
    ASSERT_TRUE(values);
    const auto& found = std::get<file::Json::Array>(values->find("values")->value());
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].find("value")->dump(), "42");
    const auto list = file::Json::parse(answer("list"));
    ASSERT_TRUE(list);
    EXPECT_EQ(std::get<file::Json::Array>(list->find("names")->value()).size(), 3U);
}

TEST_F(SessionCommandsTest, GetHasAnAnswerForPrograms) {
    file::Json data;
    ASSERT_TRUE(commands.execute("get Level", [&](const Answer& given) { data = given.data; }, english()));
    rig.run(300ms);
    commands.take_outcomes();
    EXPECT_EQ(*data.find("device"), file::Json("Boiler"));
    EXPECT_EQ(*data.find("quality"), file::Json("good"));
    EXPECT_FALSE(data.find("age_ms")->is_null());
}

// The socket's session has no events that report another project.
TEST(SessionCommands, FollowAnotherProject) {
    host::test::Rig rig(kPlant);
    const auto session = rig.open({.events = false});
    SessionCommands commands(*session, [] {});
    rig.run(300ms);
    Answers before;
    ASSERT_TRUE(commands.execute("get Level", before.reply(), english()));
    std::string other = kPlant;
    other.replace(other.find("Level"), 5, "Depth");
    rig.apply(other);
    rig.run(300ms);
    commands.take_outcomes();
    ASSERT_EQ(before.lines.size(), 1U);
    EXPECT_TRUE(before.lines[0].starts_with("ok Level ")) << before.lines[0];
    Answers after;
    ASSERT_TRUE(commands.execute("get Level", after.reply(), english()));
    ASSERT_TRUE(commands.execute("get Depth", after.reply(), english()));
    rig.run(300ms);
    commands.take_outcomes();
    ASSERT_EQ(after.lines.size(), 2U);
    EXPECT_EQ(
        after.lines[0],
        "error not_found Level: no such name among 3; `list` shows all, `values PATTERN` those that match\n");
    EXPECT_TRUE(after.lines[1].starts_with("ok Depth ")) << after.lines[1];
}

TEST_F(SessionCommandsTest, QuitIsAnsweredAtOnce) {
    EXPECT_FALSE(quit);
    EXPECT_EQ(answer("quit"), "ok\n");
    EXPECT_TRUE(quit);
}

}  // namespace session_commands_test
}  // namespace takt::console
