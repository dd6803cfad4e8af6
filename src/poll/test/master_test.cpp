// Many lines in one master.
#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll {
namespace master_test {

using namespace test;

model::Project project_of_three_lines() {
    auto made = project({device(1, {int16("a", 0).read(3).write(0x06).on_change()})},
                        {local("on"), local("go"), local("idle")});
    made.lines.push_back(made.lines[0]);
    made.lines.push_back(made.lines[0]);
    made.lines[1].devices = {device(1, {int16("b", 0).read(3).write(0x06).write_on(1)})};
    made.lines[2].devices = {device(1, {int16("c", 0).read(3).read_on(1)}),
                             device(2, {int16("d", 0).read(3).write(0x06)})};
    made.lines[2].devices[0].poll_enable = 0;
    return made;
}

std::vector<std::size_t> concerned(const Master& master, const char* name) {
    const auto lines = master.concerned(*master.store().find(name));
    return {lines.begin(), lines.end()};
}

TEST(Master, KnowsWhichLinesAChangeConcerns) {
    const auto project = project_of_three_lines();
    const auto plan = plan::make_plan(project);
    const Master master(project, plan);
    using Lines = std::vector<std::size_t>;
    EXPECT_EQ(concerned(master, "a"), Lines{0});
    EXPECT_EQ(concerned(master, "d"), Lines{2});
    EXPECT_EQ(concerned(master, "on"), Lines{2});
    EXPECT_EQ(concerned(master, "go"), (Lines{1, 2}));
    EXPECT_EQ(concerned(master, "idle"), Lines{});
}

// The outcomes of all lines arrive, in any order of requests and answers.
TEST(Master, GivesTheOutcomesOfAllLines) {
    const auto project = project_of_three_lines();
    const auto plan = plan::make_plan(project);
    Master master(project, plan);
    value::CommandId next = 1;
    for (const char* name : {"d", "a", "b", "a", "on", "d"}) {
        const auto slot = *master.store().find(name);
        const value::Value value = std::string_view(name) == "on" ? value::Value(true) : std::int64_t{1};
        ASSERT_TRUE(master.write(at(0ms), {.id = next++, .slot = slot, .value = value, .expires = at(1s)}));
    }
    EXPECT_EQ(master.take_outcome()->id, 5U) << "a local is set at once";
    EXPECT_FALSE(master.take_outcome());
    std::vector<value::CommandId> ended;
    for (const std::size_t line : {1U, 0U, 2U}) {
        master.line(line).on_tick(at(1s));
        while (const auto outcome = master.take_outcome()) {
            EXPECT_EQ(outcome->result, value::CommandResult::expired);
            ended.push_back(outcome->id);
        }
    }
    EXPECT_EQ(ended, (std::vector<value::CommandId>{3, 2, 4, 1, 6}));
    EXPECT_FALSE(master.take_outcome());
}

}  // namespace master_test
}  // namespace takt::poll
