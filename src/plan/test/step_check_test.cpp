// When a line needs pauses that show whether a unit is one response behind.
#include "timing/step_check.hpp"

#include <gtest/gtest.h>

#include "builder.hpp"

namespace takt::plan {
namespace step_check_test {

using namespace test;

Item string(int register_number, int registers) {
    return item(DataType::string, register_number, registers);
}

Responses analysed(const std::vector<Task>& tasks) {
    return response_times(tasks);
}

// 115200 bit/s: a read of a register takes 6 ms.
Microseconds hold(const model::Project& project) {
    const auto made = line_tasks(project, make_plan(project).lines[0]);
    const auto needed = holds_needed(made, responses_with_holds(made, analysed));
    Microseconds longest = 0;
    for (std::size_t i = 0; i < made.holds.size(); ++i)
        if (needed[i]) longest = std::max(longest, made.holds[i].hold);
    return longest;
}

model::Project with_turnaround(model::Project project) {
    for (auto& device : project.lines[0].devices) device.turnaround = 3ms;
    return project;
}

TEST(StepCheck, IsNeededWhereAUnitIsAskedForOneShapeWithoutPause) {
    const auto idle = with_turnaround(project({}, {int16(0).read(3).every(100ms)}));
    EXPECT_EQ(hold(idle), 0) << "it has a pause of 90 ms";

    const auto busy = with_turnaround(project({}, {int16(0).read(3).every(10ms)}));
    const auto cost = line_tasks(busy, make_plan(busy).lines[0]).jobs[0].transaction;
    EXPECT_EQ(hold(busy), cost) << "4 ms";

    const auto endless = with_turnaround(project({}, {int16(0).read(3).every(0ms)}));
    EXPECT_EQ(hold(endless), cost);

    const auto two_shapes =
        with_turnaround(project({}, {int16(0).read(3).every(40ms), real(200).read(3).every(40ms)}));
    EXPECT_EQ(hold(two_shapes), 0) << "the wrong one would be recognised";
    const auto rare =
        with_turnaround(project({}, {int16(0).read(3).every(10ms), real(200).read(3).every(5000ms)}));
    EXPECT_GT(hold(rare), 0) << "not every second";

    auto tcp = busy;
    tcp.lines[0].framing = wire::Framing::tcp;
    EXPECT_EQ(hold(tcp), 0) << "responses have numbers";
}

TEST(StepCheck, TheExchangesWithOtherUnitsArePauses) {
    auto line = with_turnaround(project({}, {int16(0).read(3).every(40ms)}));
    auto other = line.lines[0].devices[0];
    other.name = "other";
    other.address = UnitId{static_cast<std::uint8_t>(other.address.value + 1)};
    line.lines[0].devices.push_back(other);
    EXPECT_EQ(hold(line), 0);
}

TEST(StepCheck, RequestsOfOthersTakeNoPausesAway) {
    auto line = with_turnaround(project({}, {int16(0).read(3).every(1000ms)}));
    EXPECT_EQ(hold(line), 0);
    auto& variable = line.lines[0].devices[0].variables[0];
    variable.write = wire::Function::write_single_register;
    variable.written_by_clients = true;
    EXPECT_EQ(hold(line), 0) << "the response to a write repeats it";
    line.lines[0].relayed = model::SharedLine{.response_timeout = 60ms};
    EXPECT_EQ(hold(line), 0) << "they are held back";
}

// 4800 8E1: reads of 146 and 178 ms, so that the line is busy for 47.6 % of the time. Between two reads of
// the first variable there are 254 ms, but the five gaps within 1.6 s have 168 ms in the mean.
model::Project two_strings(Duration rare) {
    auto made = project({.registers_per_request = 28},
                        {string(0, 21).read(3).every(400ms), string(100, 28).read(3).every(rare)});
    made.lines[0].format = {4800, 8, wire::Parity::even, 1};
    made.lines[0].devices[0].turnaround = 12ms;
    return made;
}

TEST(StepCheck, IsNotNeededWhereTheReadsOfEachShapeLeaveAPause) {
    const auto strings = two_strings(1600ms);
    const auto made = line_tasks(strings, make_plan(strings).lines[0]);
    EXPECT_EQ(hold(strings), 0);
    EXPECT_EQ(responses_with_holds(made, analysed), response_times(made.tasks));
    EXPECT_EQ(response_times(made.tasks)[0], 325'609);

    auto fast = two_strings(1600ms);
    fast.lines[0].devices[0].variables[0].period = 300ms;
    EXPECT_GT(hold(fast), 0) << "they leave 154 ms";
    fast.lines[0].devices[0].variables[1].period = 500ms;
    EXPECT_EQ(hold(fast), 0) << "another shape in each second";
}

TEST(StepCheck, CountsReadsThatStartLate) {
    auto line = with_turnaround(project({}, {int16(0).read(3).every(100ms)}));
    const auto cost = line_tasks(line, make_plan(line).lines[0]).jobs[0].transaction;
    line.lines[0].devices[0].variables[0].period = std::chrono::microseconds(2 * cost + 50);
    EXPECT_EQ(hold(line), 0) << "each gap is 50 us longer than the pause";
    auto other = line.lines[0].devices[0];
    other.name = "other";
    other.address = UnitId{static_cast<std::uint8_t>(other.address.value + 1)};
    other.variables = {string(0, 16).read(3).every(5000ms)};
    line.lines[0].devices.push_back(other);
    EXPECT_GT(hold(line), 0) << "after its read the next ones come closer, for more than a second";
}

TEST(StepCheck, AHoldIsNoDeviceThatCanDie) {
    const auto busy = with_turnaround(project({}, {int16(0).read(3).every(10ms)}));
    const auto made = line_tasks(busy, make_plan(busy).lines[0]);
    ASSERT_GT(hold(busy), 0);
    const auto with_dead = responses_with_holds(
        made, [](const std::vector<Task>& tasks) { return response_times_with_dead_device(tasks); });
    EXPECT_EQ(with_dead, responses_with_holds(made, analysed)) << "there is no other device";
}

}  // namespace step_check_test
}  // namespace takt::plan
