#include "takt/poll/availability.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll {
namespace availability_test {

using namespace test;

Availability both(Duration observed, Duration downtime) {
    return {.observed = observed, .downtime = downtime};
}

TEST(AvailabilityMeter, KnowsNothingBeforeTheFirstState) {
    AvailabilityMeter meter;
    EXPECT_FALSE(meter.down(at(1s))) << "it is not observed";
    EXPECT_FALSE(meter.at(at(9s)).share());
    meter.begin(at(1s));
    EXPECT_FALSE(meter.at(at(9s)).share());
    meter.up(at(3s));
    EXPECT_EQ(meter.at(at(5s)), both(4s, 0s));
    EXPECT_EQ(meter.at(at(5s)).share(), 1.0);
}

TEST(AvailabilityMeter, AddsUpOutages) {
    AvailabilityMeter meter;
    meter.begin(at(0s));
    EXPECT_TRUE(meter.down(at(2s))) << "found after two seconds, nothing was known before";
    EXPECT_EQ(meter.at(at(4s)), both(4s, 4s));
    EXPECT_FALSE(meter.down(at(5s)));
    meter.up(at(10s));
    EXPECT_EQ(meter.at(at(20s)), both(20s, 10s));
    EXPECT_EQ(meter.at(at(20s)).share(), 0.5);
    EXPECT_TRUE(meter.down(at(18s)));
    EXPECT_EQ(meter.down_since(), at(18s));
    EXPECT_EQ(meter.at(at(20s)), both(20s, 12s));
}

TEST(AvailabilityMeter, APauseIsNotObserved) {
    AvailabilityMeter meter;
    meter.begin(at(0s));
    meter.up(at(1s));
    meter.down(at(6s));
    meter.pause(at(10s));
    EXPECT_EQ(meter.at(at(100s)), both(10s, 4s));
    meter.begin(at(100s));
    meter.up(at(101s));
    EXPECT_EQ(meter.at(at(110s)), both(20s, 4s));
}

DeviceStatistics statistics(const Bench& bench, std::size_t device) {
    return bench.master.line(0).device(device);
}

Availability of_line(const Bench& bench) {
    return bench.master.line(0).statistics(bench.now).availability.at(bench.now);
}

TEST(Availability, ADeadDeviceIsDownFromItsFirstFailedAttemptUntilItAnswers) {
    Bench bench(project({device(1, {int16("a", 0).read(3)}), device(2, {int16("b", 0).read(3)})}));
    bench.run_until(10s);
    EXPECT_EQ(statistics(bench, 0).availability.at(bench.now), both(10s, 0s));
    bench.players[1].dead = true;
    bench.run_until(20s);
    const auto down = statistics(bench, 0).availability.at(bench.now);
    EXPECT_GT(down.downtime, 9900ms - 1ms);
    EXPECT_LE(down.downtime, 10s);
    EXPECT_EQ(statistics(bench, 0).outages, 1U);
    EXPECT_EQ(statistics(bench, 1).availability.at(bench.now), both(20s, 0s));
    EXPECT_EQ(of_line(bench), both(20s, 0s)) << "one of its devices answers";
    bench.players[1].dead = false;
    bench.run_until(100s);
    const auto ended = statistics(bench, 0).availability.at(bench.now);
    EXPECT_EQ(ended.observed, 100s);
    EXPECT_LT(ended.downtime, 30s);
    EXPECT_GE(ended.downtime, down.downtime);
    EXPECT_EQ(statistics(bench, 0).state, DeviceState::answering);
}

TEST(Availability, ALineIsDownWhileNoneOfItsDevicesAnswers) {
    Bench bench(project({device(1, {int16("a", 0).read(3)}), device(2, {int16("b", 0).read(3)})}));
    bench.run_until(10s);
    bench.players[1].dead = true;
    bench.run_until(20s);
    bench.players[2].dead = true;
    bench.run_until(30s);
    EXPECT_GT(of_line(bench).downtime, 9800ms);
    EXPECT_LE(of_line(bench).downtime, 10s);
    bench.players[2].dead = false;
    bench.run_until(100s);
    EXPECT_LT(of_line(bench).downtime, 30s);
}

TEST(Availability, ALostLinkIsOneOutageOfAllDevicesUntilTheyAnswer) {
    Bench bench(project({device(1, {int16("a", 0).read(3)}), device(2, {int16("b", 0).read(3)})}));
    bench.run_until(10s);
    bench.players[2].dead = true;
    bench.link(false);
    bench.run_until(15s);
    for (const std::size_t d : {0U, 1U}) {
        EXPECT_EQ(statistics(bench, d).availability.at(bench.now), both(15s, 5s)) << d;
        EXPECT_EQ(statistics(bench, d).outages, 1U) << d;
    }
    EXPECT_EQ(of_line(bench), both(15s, 5s));
    bench.link(true);
    bench.run_until(25s);
    EXPECT_LT(statistics(bench, 0).availability.at(bench.now).downtime, 5210ms);
    EXPECT_EQ(statistics(bench, 1).availability.at(bench.now), both(25s, 15s)) << "it has not answered yet";
    EXPECT_EQ(statistics(bench, 1).outages, 1U) << "the same outage";
    EXPECT_LT(of_line(bench).downtime, 5210ms);
}

TEST(Availability, ADeviceThatNeverAnswersWasNeverAvailable) {
    Bench bench(project({device(1, {int16("a", 0).read(3)})}));
    bench.players[1].dead = true;
    bench.run_until(10s);
    EXPECT_EQ(statistics(bench, 0).availability.at(bench.now).share(), 0.0);
    EXPECT_EQ(of_line(bench).share(), 0.0);
}

TEST(Availability, ADeviceThatIsSwitchedOffIsNotObserved) {
    auto plant = project({device(1, {int16("a", 0).read(3)})}, {local("enable")});
    plant.lines[0].devices[0].poll_enable = 0;
    Bench bench(plant);
    bench.run_until(10s);
    EXPECT_FALSE(statistics(bench, 0).availability.at(bench.now).share());
    ASSERT_TRUE(bench.set("enable", true));
    bench.run_until(20s);
    EXPECT_EQ(statistics(bench, 0).availability.at(bench.now), both(10s, 0s));
    ASSERT_TRUE(bench.set("enable", false));
    bench.run_until(30s);
    EXPECT_EQ(statistics(bench, 0).availability.at(bench.now), both(10s, 0s));
    EXPECT_EQ(bench.master.line(0).request(0).real_period.max(), 100ms);
}

// Two of five responses are damaged: the attempts cost time, and the period becomes longer.
TEST(Availability, ALineWithDamagedResponsesLooksWorseThanAHealthyOne) {
    const auto plant = project({device(1, {int16("a", 0).read(3).every(20ms)})});
    Bench healthy(plant);
    healthy.run_until(60s);
    Bench damaged(plant);
    int count = 0;
    damaged.players[1].silent_to = [&](const wire::Request&) { return ++count % 5 < 2; };
    damaged.run_until(60s);
    const auto good = healthy.master.line(0).request(0);
    const auto bad = damaged.master.line(0).request(0);
    EXPECT_NEAR(static_cast<double>(good.real_period.mean().count()), 20e6, 1e5);
    EXPECT_GT(bad.real_period.mean(), 40ms);
    EXPECT_NEAR(static_cast<double>(bad.real_period.mean().count()),
                60e9 / static_cast<double>(bad.counters.answered), 5e6);
    EXPECT_GT(damaged.master.line(0).statistics(damaged.now).measured_cycle,
              healthy.master.line(0).statistics(healthy.now).measured_cycle);
}

TEST(Availability, NothingAnsweredHasNoPeriodAndNoCycle) {
    Bench bench(project({device(1, {int16("a", 0).read(3)})}));
    bench.players[1].dead = true;
    bench.run_until(10s);
    EXPECT_EQ(bench.master.line(0).request(0).real_period.count(), 0U);
    EXPECT_EQ(bench.master.line(0).statistics(bench.now).measured_cycle, 0s);
}

}  // namespace availability_test
}  // namespace takt::poll
