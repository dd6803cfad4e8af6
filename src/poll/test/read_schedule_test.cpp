// The schedule of reads without a line. The order of what is sent is tested in polling_test.cpp and
// read_queue_test.cpp.
#include "reads/read_schedule.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll::test {
namespace read_schedule_test {

std::optional<std::int64_t> round_of(const ReadSchedule& schedule, std::size_t read, Duration period) {
    return schedule.number_of(schedule.round(read), read, period);
}

/// A device with attempts 2 and three requests: 0 polls the variable 0 each 100 ms, 1 the variables 0 and 1
/// each 300 ms, 2 reads the variable 1 by a trigger.
struct Polled {
    explicit Polled(std::size_t fewest_in_queue = 100) : schedule({variables, devices, requests}, arrivals) {
        models = {int16("a", 0).read(3), int16("b", 1).read(3)};
        for (const auto& model : models) variables.push_back({.model = &model});
        devices.resize(1);
        devices[0].health = DeviceHealth(2, {.first = 1s, .limit = 8s}, true);
        devices[0].requests = {0, 1, 2};
        plans.resize(3);
        plans[0].period = 100ms;
        plans[1].period = 300ms;
        plans[1].phase = 50ms;
        plans[1].quantity = 2;
        requests.resize(3);
        for (std::size_t r = 0; r < 3; ++r) {
            requests[r].plan = &plans[r];
            requests[r].read =
                ReadJob{.request = prepared({Function::read_holding_registers, DataAddress{0}, 1}),
                        .rank = 2 * r,
                        .polled = r < 2};
        }
        requests[0].variables = {0};
        requests[1].variables = {0, 1};
        requests[2].variables = {1};
        requests[0].read->deadline = 40ms;
        schedule.add(0, 100ms, std::nullopt);
        schedule.add(1, 300ms, std::nullopt);
        schedule.add(2, 0ms, RateLimitedEvent(model::RateLimit{1s, 1}));
        schedule.set_queue(fewest_in_queue);
        schedule.set_origin(at(0s));
        schedule.restart(at(0s), 0);
    }
    ReadCause start(Instant t, std::size_t read, bool by_trigger = false) {
        requests[read].read->last_start = t;
        return schedule.start(t, read, by_trigger);
    }
    /// An attempt that fails.
    bool fail(Instant t, std::size_t read) {
        start(t, read);
        schedule.ended(read);
        return schedule.failed(t, read);
    }

    std::vector<model::Variable> models;
    std::vector<plan::Request> plans;
    std::vector<VariableRun> variables;
    std::vector<DeviceRun> devices;
    std::vector<RequestRun> requests;
    ArrivalCounter arrivals;
    ReadSchedule schedule;
};

TEST(ReadSchedule, ReadsAreReleasedOnTheGridOfTheLine) {
    Polled line;
    EXPECT_EQ(line.schedule.due(0), at(0s));
    EXPECT_EQ(line.schedule.due(1), at(50ms)) << "its phase";
    EXPECT_EQ(line.start(at(250ms), 0), ReadCause::release);
    EXPECT_FALSE(line.schedule.waits(0));
    EXPECT_EQ(line.schedule.skipped(0), 2U);
    line.schedule.ended(0);
    EXPECT_TRUE(line.schedule.waits(0));
    EXPECT_EQ(line.schedule.due(0), at(300ms));
    EXPECT_FALSE(line.schedule.waits(2)) << "it is not polled";
}

TEST(ReadSchedule, AFailedReadGoesBackIntoTheQueue) {
    Polled line;
    line.start(at(0s), 0);
    line.schedule.ended(0);
    line.schedule.again(at(30ms), 0);
    EXPECT_EQ(line.schedule.due(0), at(30ms));
    EXPECT_EQ(line.schedule.polled(0).since, at(30ms));
    EXPECT_EQ(line.start(at(40ms), 0), ReadCause::repetition);
    line.schedule.ended(0);
    EXPECT_EQ(line.schedule.due(0), at(100ms)) << "a repetition serves no release";
}

TEST(ReadSchedule, AReadThatIsNotDueIsAProbe) {
    Polled line;
    line.start(at(0s), 0);
    line.schedule.ended(0);
    EXPECT_EQ(line.start(at(10ms), 0), ReadCause::probe);
    line.schedule.ended(0);
    EXPECT_EQ(line.schedule.due(0), at(100ms));
    EXPECT_EQ(line.start(at(10ms), 2), ReadCause::probe) << "it was not triggered";
}

TEST(ReadSchedule, ExceptionsThatMeanBusyHoldItBack) {
    Polled line;
    line.schedule.answered(at(0s), 0, true);
    const Instant first = line.schedule.due(0);
    EXPECT_GT(first, at(0s));
    line.schedule.answered(first, 0, true);
    EXPECT_EQ(line.schedule.due(0) - first, 2 * (first - at(0s)));
    const Instant second = line.schedule.due(0);
    line.schedule.answered(second, 0, false);
    line.schedule.answered(second, 0, true);
    EXPECT_EQ(line.schedule.due(0) - second, first - at(0s)) << "another answer resets the back-off";
}

TEST(ReadSchedule, AReadThatFailsTooOftenIsSlowedDown) {
    Polled line;
    EXPECT_EQ(line.schedule.polled(0).allowed, 40ms);
    EXPECT_FALSE(line.fail(at(0s), 0));
    EXPECT_TRUE(line.fail(at(100ms), 0)) << "the device allows two attempts";
    EXPECT_EQ(line.schedule.due(0), at(1100ms));
    EXPECT_EQ(line.schedule.released(0), at(200ms));
    const auto polled = line.schedule.polled(0);
    EXPECT_TRUE(polled.slowed);
    EXPECT_EQ(polled.allowed, 1s);
    EXPECT_EQ(polled.since, at(1100ms));
    EXPECT_FALSE(line.schedule.slowed(1)) << "others are not";
    line.schedule.restart(at(500ms), 0);
    EXPECT_FALSE(line.schedule.slowed(0));
    EXPECT_EQ(line.schedule.due(0), at(500ms));
}

TEST(ReadSchedule, TriggersPassTheirBucketAndAreMerged) {
    Polled line;
    line.schedule.next_change();
    line.schedule.pull_trigger(at(0s), 2);
    const auto order = line.schedule.event(2).order;
    line.schedule.next_change();
    line.schedule.pull_trigger(at(1ms), 2);
    EXPECT_EQ(line.schedule.event(2).order, order) << "merged";
    EXPECT_TRUE(line.schedule.triggered(2));
    EXPECT_TRUE(line.schedule.admit(at(1ms), 2));
    EXPECT_EQ(line.schedule.line_token(2), nullptr) << "it has a bucket of its own";
    EXPECT_EQ(line.start(at(2ms), 2, true), ReadCause::trigger);
    EXPECT_EQ(round_of(line.schedule, 2, 0ms), -1);
    line.schedule.next_change();
    line.schedule.pull_trigger(at(3ms), 2);
    EXPECT_FALSE(line.schedule.triggered(2)) << "it is in flight";
    line.schedule.ended(2);
    EXPECT_TRUE(line.schedule.triggered(2));
    EXPECT_FALSE(line.schedule.admit(at(3ms), 2)) << "one a second";
    EXPECT_TRUE(line.schedule.admit(at(1s), 2));
    line.schedule.drop_trigger(2);
    EXPECT_FALSE(line.schedule.triggered(2));
}

TEST(ReadSchedule, ATriggeredReadThatFailedNeedsNoNewAdmission) {
    Polled line;
    line.schedule.pull_trigger(at(0s), 2);
    line.start(at(0s), 2, true);
    line.schedule.ended(2);
    line.schedule.again(at(1ms), 2);
    EXPECT_TRUE(line.schedule.triggered(2));
    EXPECT_TRUE(line.schedule.admit(at(1ms), 2));
}

TEST(ReadSchedule, PartsOfAValueBelongToThePeriodOfTheValue) {
    Polled line;
    for (const auto t : {100ms, 200ms, 300ms}) {
        line.start(at(t), 0);
        line.schedule.ended(0);
        EXPECT_EQ(round_of(line.schedule, 0, 0ms), t / 100ms);
        EXPECT_EQ(round_of(line.schedule, 0, 200ms), t / 200ms);
    }
    line.start(at(350ms), 2);
    EXPECT_EQ(round_of(line.schedule, 2, 200ms), std::nullopt) << "it has no period";
}

TEST(ReadSchedule, TheReadThatWasSentLeastRecentlyProbes) {
    Polled line;
    EXPECT_EQ(line.schedule.oldest(0), 0U);
    line.start(at(1s), 0);
    line.start(at(3s), 1);
    EXPECT_EQ(line.schedule.oldest(0), 2U);
    line.start(at(2s), 2);
    EXPECT_EQ(line.schedule.oldest(0), 0U);
    EXPECT_EQ(line.schedule.last_start(0), at(3s));
}

TEST(ReadSchedule, AReturnReadsEachVariableOnce) {
    Polled line;
    line.schedule.restart(at(10ms), 0);
    EXPECT_EQ(line.schedule.due(1), at(50ms));
    line.schedule.release_at_once(at(10ms), 0, {});
    EXPECT_EQ(line.schedule.due(1), at(10ms)) << "the longest has both variables";
    EXPECT_EQ(line.schedule.due(0), at(100ms));
    EXPECT_FALSE(line.schedule.any_due(at(9ms), 0));
    EXPECT_TRUE(line.schedule.any_due(at(10ms), 0));
}

TEST(ReadSchedule, TheQueueFollowsEachChange) {
    const bus::Arbiter arbiter(1, 1s, false);
    Polled line(3);
    ASSERT_TRUE(line.schedule.has_queue());
    const auto first = [&](Duration t) {
        line.schedule.settle(at(t), arbiter);
        std::optional<std::size_t> found;
        line.schedule.visit_ready(0, [&](std::size_t read) {
            found = read;
            return false;
        });
        EXPECT_EQ(line.schedule.any_ready(0), found.has_value());
        return found;
    };
    EXPECT_EQ(first(0ms), 0U);
    line.start(at(0s), 0);
    EXPECT_EQ(first(0ms), std::nullopt);
    EXPECT_EQ(line.schedule.next_wakeup(0), at(50ms));
    line.schedule.ended(0);
    line.schedule.again(at(10ms), 0);
    EXPECT_EQ(first(10ms), 0U);
    line.schedule.hold_back(at(10ms), 0);
    EXPECT_EQ(first(10ms), std::nullopt);
    line.schedule.release_at(at(20ms), 1);
    EXPECT_EQ(first(20ms), 1U);
    line.schedule.restart(at(20ms), 0);
    EXPECT_EQ(first(20ms), std::nullopt);
    EXPECT_EQ(line.schedule.next_wakeup(0), at(50ms));
}

TEST(ReadSchedule, NoVariableIsReadLaterByAnotherPlan) {
    Polled line;
    line.start(at(0s), 0);
    line.schedule.ended(0);
    const std::vector<RequestRun> old_requests = line.requests;
    const auto old = line.schedule.take_reads({line.variables, line.devices, old_requests});
    line.requests.resize(1);
    line.requests[0].plan = &line.plans[1];
    line.requests[0].variables = {0, 1};
    line.schedule.add(0, 300ms, std::nullopt);
    line.schedule.set_queue(100);
    line.schedule.follow(at(60ms), 0);
    EXPECT_EQ(line.schedule.due(0), at(350ms));
    line.schedule.keep_due(at(60ms), old);
    EXPECT_EQ(line.schedule.due(0), at(50ms)) << "the variable 1 was due then";
}

TEST(ReadSchedule, ATriggerMovesToTheReadOfAnotherPlan) {
    Polled line;
    line.schedule.next_change();
    line.schedule.pull_trigger(at(0s), 2);
    const std::vector<RequestRun> old_requests = line.requests;
    const auto old = line.schedule.take_reads({line.variables, line.devices, old_requests});
    for (const std::size_t r : {0U, 1U}) line.schedule.add(r, 100ms, std::nullopt);
    line.schedule.add(2, 0ms, RateLimitedEvent(std::nullopt));
    EXPECT_FALSE(line.schedule.triggered(2));
    line.schedule.carry_trigger(2, old, 2);
    EXPECT_TRUE(line.schedule.triggered(2));
    EXPECT_EQ(line.schedule.event(2).order, 1U);
}

TEST(ReadSchedule, AnotherPollerGoesOnWithoutTheTriggers) {
    Polled old;
    old.fail(at(0s), 0);
    old.schedule.again(at(20ms), 0);
    old.schedule.pull_trigger(at(0s), 2);
    Polled line;
    line.schedule.take_over(old.schedule);
    for (std::size_t r = 0; r < 3; ++r) line.schedule.take_over(r, old.schedule, r);
    EXPECT_EQ(line.schedule.due(0), at(20ms));
    EXPECT_FALSE(line.schedule.triggered(2)) << "it is pulled again where its trigger is still set";
    EXPECT_TRUE(line.fail(at(100ms), 0)) << "the second failure in a row";
}

}  // namespace read_schedule_test
}  // namespace takt::poll::test
