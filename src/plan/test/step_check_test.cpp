// When a line needs pauses that show whether a unit is one response behind.
#include "../step_check.hpp"

#include <gtest/gtest.h>

#include "builder.hpp"

namespace takt::plan {
namespace step_check_test {

using namespace test;

// 115200 bit/s: a read of a register takes 6 ms.
Microseconds hold(const model::Project& project) {
    const auto made = line_tasks(project, make_plan(project).lines[0]);
    Microseconds longest = 0;
    for (const StepHold& hold : made.holds) longest = std::max(longest, hold.hold);
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

}  // namespace step_check_test
}  // namespace takt::plan
