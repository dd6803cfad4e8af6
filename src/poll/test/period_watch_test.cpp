// What a PeriodMeter measures is tested in src/bus/test.
#include "reads/period_watch.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"
#include "line/transfer.hpp"

namespace takt::poll::test {
namespace period_watch_test {

wire::PreparedRead a_read() {
    return prepared({Function::read_holding_registers, DataAddress{0}, 1});
}

/// Two requests of 100 ms: 0 reads the variable 0 and the first part of 1, 1 reads the rest of 1.
struct Watched {
    Watched() : watch({variables, devices, requests}) {
        models = {int16("a", 0).read(3), real("b", 1).read(3)};
        for (const auto& model : models) variables.push_back({.model = &model});
        plans.resize(2);
        for (auto& plan : plans) plan.period = 100ms;
        plans[0].start = 0;
        plans[1].start = 2;
        requests.resize(2);
        requests[0].variables = {0, 1};
        requests[1].variables = {1};
        for (std::size_t r = 0; r < 2; ++r) {
            requests[r].plan = &plans[r];
            requests[r].read = ReadJob{.request = a_read(), .polled = true};
        }
        watch.set_requests();
    }
    std::vector<model::Variable> models;
    std::vector<plan::Request> plans;
    std::vector<VariableRun> variables;
    std::vector<DeviceRun> devices;
    std::vector<RequestRun> requests;
    PeriodWatch watch;
};

TEST(PeriodWatch, AValueInPartsHasThePeriodOfItsFirstPart) {
    Watched line;
    for (auto t = 0ms; t <= 1s; t += 100ms) {
        line.watch.answered(at(t), at(t), 0);
        line.watch.answered(at(t + 30ms), at(t + 30ms), 1);
    }
    EXPECT_EQ(line.watch.request(0).recent(), 100ms);
    EXPECT_EQ(line.watch.request(1).recent(), 100ms);
    EXPECT_EQ(line.watch.variable(0).real().count(), 10U);
    EXPECT_EQ(line.watch.variable(1).real().count(), 10U) << "not of both parts";
}

TEST(PeriodWatch, AReadThatIsAwaitedForMoreThanFourPeriodsIsAnOverrunOnce) {
    Watched line;
    EXPECT_EQ(line.watch.next_overrun(), kNever) << "nothing has started";
    line.watch.started(at(0s), 1);
    EXPECT_EQ(line.watch.take_overrun(at(400ms)), std::nullopt);
    const Instant due = line.watch.next_overrun();
    EXPECT_GT(due, at(400ms));
    EXPECT_LT(due, at(500ms));
    EXPECT_EQ(line.watch.take_overrun(due), 1U);
    EXPECT_TRUE(line.watch.request(1).overrun());
    EXPECT_EQ(line.watch.take_overrun(at(10s)), std::nullopt);
    EXPECT_EQ(line.watch.next_overrun(), kNever);
}

TEST(PeriodWatch, AnInterruptionIsNoOverrun) {
    Watched line;
    line.watch.started(at(0s), 0);
    line.watch.interrupt(0);
    EXPECT_EQ(line.watch.next_overrun(), kNever);
    EXPECT_FALSE(line.watch.started(at(10s), 0));
    EXPECT_FALSE(line.watch.request(0).overrun());
    EXPECT_FALSE(line.watch.variable(0).overrun());
}

TEST(PeriodWatch, APauseIsNoPeriod) {
    for (const bool paused : {false, true}) {
        Watched line;
        line.watch.answered(at(0s), at(0s), 0);
        if (paused) line.watch.pause(0);
        line.watch.answered(at(10s), at(10s), 0);
        EXPECT_EQ(line.watch.request(0).real().count(), paused ? 0U : 1U);
        EXPECT_EQ(line.watch.variable(0).real().count(), paused ? 0U : 1U);
    }
}

TEST(PeriodWatch, NewRequestsBeginAnewAndVariablesGoOn) {
    Watched line;
    line.watch.started(at(0s), 0);
    line.watch.answered(at(0s), at(0s), 0);
    line.watch.answered(at(100ms), at(100ms), 0);
    const auto before = line.watch.requests();
    line.watch.set_requests();
    EXPECT_EQ(line.watch.request(0).real().count(), 0U);
    EXPECT_EQ(line.watch.variable(0).real().count(), 1U);
    EXPECT_EQ(line.watch.next_overrun(), kNever);
    line.watch.carry_request(0, before[0]);
    EXPECT_EQ(line.watch.request(0).real().count(), 1U);
    EXPECT_NE(line.watch.next_overrun(), kNever) << "it is still awaited";
}

}  // namespace period_watch_test
}  // namespace takt::poll::test
