#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll {
namespace delays_test {

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

DeviceStatistics statistics(const Bench& bench) {
    return bench.master.line(0).device(0);
}

void expect_finding(const Bench& bench, Setting setting, Duration delay, Duration limit, Duration advised) {
    ASSERT_TRUE(statistics(bench).delays);
    const auto finding = *statistics(bench).delays;
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
    expect_finding(bench, Setting::response_timeout, 148ms, 100ms, 200ms);
    ASSERT_EQ(bench.observed.delays.size(), 2U);
    EXPECT_EQ(bench.observed.delays[0].advised, 0ms) << "the first one may be a pause";

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
    EXPECT_EQ(bench.observed.delays.size(), 2U);
    expect_finding(bench, Setting::response_timeout, 121ms, 100ms, 150ms);
    bench.players[1].turnaround = 190ms;
    bench.run_until(100s);
    ASSERT_EQ(bench.observed.delays.size(), 3U);
    expect_finding(bench, Setting::response_timeout, 190ms, 100ms, 300ms);
}

// The first responses look like those to the requests after them. A surplus one shows the delay.
TEST(Delays, AResponseAfterTheLateLimitIsNamedWithItsOwnDelay) {
    Bench bench(project({slow_device(100ms)}));
    bench.players[1].turnaround = 260ms;
    bench.run_until(60s);
    expect_finding(bench, Setting::response_timeout, 260ms, 100ms, 400ms);
}

// The late response shows that the device does not answer in order: what was read since it was missing may
// be that of an earlier request.
TEST(Delays, AResponseOutOfOrderMarksTheValuesThatWereReadSince) {
    Bench bench(project({device(1, {int16("a", 0).read(3).every(1s), int16("b", 100).read(4).every(1s)})}));
    bench.run_until(3500ms);
    bench.players[1].silent_about = {0};
    bench.run_until(4050ms);
    bench.players[1].silent_about = {};
    bench.run_until(7500ms);
    ASSERT_EQ(bench.slot("a").quality, value::Quality::good);
    const std::uint8_t late[] = {3, 2, 0, 7};
    const auto frame = wire::encode_frame(wire::Framing::rtu, UnitId{1}, 0, late);
    bench.master.line(0).on_bytes(bench.now, frame.span());
    EXPECT_EQ(bench.slot("a").quality, value::Quality::uncertain);
    EXPECT_EQ(bench.slot("a").reason, value::Reason::ambiguous);
    EXPECT_EQ(bench.slot("b").quality, value::Quality::good);
    bench.run_until(9500ms);
    EXPECT_EQ(bench.slot("a").quality, value::Quality::good);
}

// A device that answered twice is one response behind. A response that nothing asked for shows it, unless it
// only repeats the last one.
TEST(Delays, ASurplusResponseMarksTheValuesThatWereReadSince) {
    Bench bench(project({device(1, {int16("a", 0).read(3).every(1s), int16("b", 100).read(3).every(1s),
                                    int16("c", 0).read(4).every(10s)})}));
    bench.run_until(3500ms);
    const auto receive = [&](std::uint8_t low) {
        const std::uint8_t pdu[] = {3, 2, 0x55, low};
        const auto frame = wire::encode_frame(wire::Framing::rtu, UnitId{1}, 0, pdu);
        bench.master.line(0).on_bytes(bench.now, frame.span());
    };
    for (const auto* const name : {"a", "b", "c"}) ASSERT_EQ(bench.slot(name).quality, value::Quality::good);
    receive(1);
    EXPECT_EQ(bench.slot("b").quality, value::Quality::uncertain);
    EXPECT_EQ(bench.slot("b").reason, value::Reason::ambiguous);
    EXPECT_EQ(bench.slot("c").quality, value::Quality::good) << "of another shape";
    EXPECT_EQ(statistics(bench).surplus, 1U);
    EXPECT_EQ(bench.observed.surplus, 1);
    bench.run_until(4500ms);
    EXPECT_EQ(bench.slot("b").quality, value::Quality::good);
    receive(1);
    EXPECT_EQ(bench.slot("b").quality, value::Quality::uncertain);
    EXPECT_EQ(bench.observed.surplus, 1) << "named once";
}

TEST(Delays, DevicesWithSwappedAddressesAreNotLate) {
    Bench bench(project({device(1, {int16("a", 0).read(3)}), device(2, {int16("b", 0).read(3)})}));
    bench.players[1].answers_as = 2;
    bench.players[2].answers_as = 1;
    bench.run_until(30s);
    for (const std::size_t index : {0U, 1U}) {
        const auto device = bench.master.line(0).device(index);
        EXPECT_EQ(device.failure, value::Reason::unexpected_reply);
        EXPECT_EQ(device.foreign, device.counters.timeouts);
        EXPECT_EQ(device.late, 0U);
        EXPECT_FALSE(device.delays);
        EXPECT_EQ(device.surplus, 0U);
    }
}

// It is not known at once which device has sent the frame.
TEST(Delays, AResponseWithTheUnitOfAnotherDeviceIsNoSurplusOfThatOne) {
    Bench bench(project({device(1, {int16("a", 0).read(3)}), device(2, {int16("b", 100).read(3)})}));
    bench.players[1].answers_as = 2;
    bench.run_until(10s);
    const auto innocent = bench.master.line(0).device(1);
    EXPECT_EQ(innocent.state, DeviceState::answering);
    EXPECT_EQ(innocent.surplus, 0U);
    EXPECT_FALSE(innocent.shifted);
    EXPECT_EQ(bench.observed.surplus, 0);
    EXPECT_EQ(bench.master.line(0).device(0).failure, value::Reason::unexpected_reply);
}

TEST(Delays, AResponseLaterThanTheTurnaroundIsNamedThoughItIsInTime) {
    Bench bench(project({slow_device(500ms, 20ms)}));
    bench.players[1].turnaround = 60ms;
    bench.run_until(1500ms);
    EXPECT_FALSE(statistics(bench).delays) << "not for a single one";
    bench.run_until(10s);
    EXPECT_EQ(statistics(bench).late, 0U);
    expect_finding(bench, Setting::turnaround, 60ms, 20ms, 80ms);
    EXPECT_EQ(bench.observed.delays.size(), 1U);
}

TEST(Delays, ATimeoutDerivedFromTheTurnaroundNamesTheTurnaround) {
    auto plant = project({slow_device(500ms, 20ms, false)});
    Bench bench(plant);
    bench.players[1].turnaround = 60ms;
    bench.run_until(30s);
    EXPECT_GT(statistics(bench).late, 0U);
    expect_finding(bench, Setting::turnaround, 60ms, 20ms, 80ms);

    plant.lines[0].devices[0].turnaround = statistics(bench).delays->advised;
    Bench advised(plant);
    advised.players[1].turnaround = 60ms;
    advised.run_until(30s);
    EXPECT_EQ(statistics(advised).counters.answered, 30U);
    EXPECT_FALSE(statistics(advised).delays);
}

model::Device learning_device(Duration response_timeout = 500ms) {
    auto made = slow_device(response_timeout, {}, false);
    made.learn_turnaround = true;
    return made;
}

TEST(Delays, TheTurnaroundIsMeasuredFromTheEndOfTheRequestToTheFirstByte) {
    Bench bench(project({slow_device(100ms)}));
    bench.players[1].turnaround = 12ms;
    bench.run_until(30s);
    bench.players[1].turnaround = 31ms;
    bench.run_until(33s);
    const auto measured = bench.master.line(0).measured(0);
    EXPECT_EQ(measured.exchanges, statistics(bench).counters.answered);
    EXPECT_EQ(measured.attempts, measured.exchanges);
    EXPECT_NEAR(static_cast<double>(measured.longest.count()), 31e6, 1e4);
    EXPECT_GE(measured.p999, 12ms);
    EXPECT_EQ(measured.late, 0U);
}

TEST(Delays, ALearntTimeoutGrowsWithALateResponseUntilTheDeviceIsInTime) {
    Bench bench(project({learning_device()}));
    bench.players[1].turnaround = 5ms;
    bench.run_until(150s);
    const auto times = bench.master.line(0).learnt_times();

    auto plant = project({learning_device()});
    plant.lines[0].devices[0].times = times[0];
    Bench next(plant);
    next.players[1].turnaround = 5ms;
    next.run_until(10s);
    EXPECT_EQ(statistics(next).counters.answered, 10U);
    next.players[1].turnaround = 70ms;  // the time-out is 20 ms
    next.run_until(20s);
    expect_finding(next, Setting::learnt_timeout, 70ms, 20ms, 140ms);
    EXPECT_EQ(statistics(next).late, 1U);
    EXPECT_GE(statistics(next).counters.answered, 18U);
    const auto measured = next.master.line(0).measured(0);
    EXPECT_NEAR(static_cast<double>(measured.lateness.count()), 70e6, 1e4);
    EXPECT_GT(measured.exchanges, 160U) << "of both runs";
}

TEST(Delays, ADeviceThatWasLateInAnEarlierRunIsNamedFromTheStart) {
    auto plant = project({slow_device(100ms)});
    plant.lines[0].devices[0].times.measured = {
        .attempts = 300, .late = 3, .lateness = 412ms, .next_latest = {{412ms, 412ms}}};
    Bench bench(plant);
    expect_finding(bench, Setting::response_timeout, 412ms, 100ms, 500ms);
    EXPECT_TRUE(bench.observed.delays.empty()) << "nothing has happened yet";
    plant.lines[0].devices[0].response_timeout = 500ms;
    Bench advised(plant);
    EXPECT_FALSE(statistics(advised).delays);
}

TEST(Delays, AHealthyDeviceHasNoFinding) {
    Bench bench(project({slow_device(100ms, 20ms)}));
    bench.players[1].turnaround = 20ms;
    bench.run_until(60s);
    EXPECT_FALSE(statistics(bench).delays);
    EXPECT_TRUE(bench.observed.delays.empty());
}

}  // namespace delays_test
}  // namespace takt::poll
