#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll {
namespace {

using namespace test;
using Setting = DelayFinding::Setting;

model::Device slow_device(Duration response_timeout, std::optional<Duration> turnaround = {},
                          bool timeout_is_set = true) {
    auto made = device(1, {int16("a", 0).read(3).every(1s)});
    made.response_timeout = response_timeout;
    made.response_timeout_set = timeout_is_set;
    made.turnaround = turnaround;
    return made;
}

const DeviceStatistics& statistics(const Bench& bench) {
    return bench.master.line(0).device(0);
}

void expect_finding(const Bench& bench, Setting setting, Duration delay, Duration limit, Duration advised) {
    ASSERT_TRUE(statistics(bench).delays);
    const auto& finding = *statistics(bench).delays;
    EXPECT_EQ(finding.setting, setting);
    EXPECT_NEAR(static_cast<double>(finding.delay.count()), static_cast<double>(delay.count()), 1e4);
    EXPECT_EQ(finding.limit, limit);
    EXPECT_EQ(finding.advised, advised);
}

TEST(Delays, ALateResponseIsNamedOnceWithAValueThatWorks) {
    Bench bench(project({slow_device(100ms)}));
    bench.players[1].turnaround = 148ms;
    bench.run_until(30s);
    EXPECT_GT(statistics(bench).late, 0U);
    EXPECT_EQ(statistics(bench).counters.answered, 0U);
    expect_finding(bench, Setting::response_timeout, 148ms, 100ms, 300ms);
    EXPECT_EQ(bench.observed.delays.size(), 1U);

    Bench advised(project({slow_device(statistics(bench).delays->advised)}));
    advised.players[1].turnaround = 148ms;
    advised.run_until(30s);
    EXPECT_EQ(statistics(advised).counters.answered, 30U);
    EXPECT_EQ(statistics(advised).late, 0U);
    EXPECT_FALSE(statistics(advised).delays);
}

TEST(Delays, ASlowerResponseIsReportedAgainWhenTheAdviceGrows) {
    Bench bench(project({slow_device(100ms)}));
    bench.players[1].turnaround = 120ms;
    bench.run_until(10s);
    bench.players[1].turnaround = 121ms;
    bench.run_until(20s);
    EXPECT_EQ(bench.observed.delays.size(), 1U);
    expect_finding(bench, Setting::response_timeout, 121ms, 100ms, 300ms);
    bench.players[1].turnaround = 190ms;
    bench.run_until(100s);
    ASSERT_EQ(bench.observed.delays.size(), 2U);
    expect_finding(bench, Setting::response_timeout, 190ms, 100ms, 400ms);
}

// The first responses look like those to the requests after them. A surplus one shows the delay.
TEST(Delays, AResponseAfterTheLateLimitIsNamedWithItsOwnDelay) {
    Bench bench(project({slow_device(100ms)}));
    bench.players[1].turnaround = 260ms;
    bench.run_until(60s);
    expect_finding(bench, Setting::response_timeout, 260ms, 100ms, 600ms);
}

TEST(Delays, AResponseLaterThanTheTurnaroundIsNamedThoughItIsInTime) {
    Bench bench(project({slow_device(500ms, 20ms)}));
    bench.players[1].turnaround = 60ms;
    bench.run_until(1500ms);
    EXPECT_FALSE(statistics(bench).delays) << "not for a single one";
    bench.run_until(10s);
    EXPECT_EQ(statistics(bench).late, 0U);
    expect_finding(bench, Setting::turnaround, 60ms, 20ms, 150ms);
    EXPECT_EQ(bench.observed.delays.size(), 1U);
}

TEST(Delays, ATimeoutDerivedFromTheTurnaroundNamesTheTurnaround) {
    auto plant = project({slow_device(500ms, 20ms, false)});
    Bench bench(plant);
    bench.players[1].turnaround = 60ms;
    bench.run_until(30s);
    EXPECT_GT(statistics(bench).late, 0U);
    expect_finding(bench, Setting::turnaround, 60ms, 20ms, 150ms);

    plant.lines[0].devices[0].turnaround = statistics(bench).delays->advised;
    Bench advised(plant);
    advised.players[1].turnaround = 60ms;
    advised.run_until(30s);
    EXPECT_EQ(statistics(advised).counters.answered, 30U);
    EXPECT_FALSE(statistics(advised).delays);
}

TEST(Delays, AHealthyDeviceHasNoFinding) {
    Bench bench(project({slow_device(100ms, 20ms)}));
    bench.players[1].turnaround = 20ms;
    bench.run_until(60s);
    EXPECT_FALSE(statistics(bench).delays);
    EXPECT_TRUE(bench.observed.delays.empty());
}

}  // namespace
}  // namespace takt::poll
