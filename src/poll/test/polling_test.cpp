// Reading: the requests, their times and order, and the resulting values.
#include <gtest/gtest.h>

#include <set>

#include "bench.hpp"

namespace takt::poll {
namespace polling_test {

using namespace test;
using value::Quality;
using value::Reason;

std::vector<Item> scenario_1() {
    std::vector<Item> items;
    for (int i = 0; i < 10; ++i) items.push_back(real("f" + std::to_string(i), 2 * i).read(3));
    return items;
}

TEST(Polling, Scenario1SendsExactlyItsOneRequest) {
    Bench bench(project({device(16, scenario_1())}));
    // 1.0, 2.0, 3.0, 4.0, 5.0 with the low register first
    const std::uint16_t kHigh[] = {0x3F80, 0x4000, 0x4040, 0x4080, 0x40A0};
    for (std::uint16_t i = 0; i < 5; ++i)
        bench.players[16].registers[static_cast<std::uint16_t>(2 * i + 1)] = kHigh[i];
    bench.run_until(950ms);
    ASSERT_EQ(bench.sent.size(), 10U);
    for (const auto& request : bench.sent) EXPECT_EQ(request.bytes, "10 03 00 00 00 14 46 84");
    for (int i = 0; i < 5; ++i) {
        const auto& slot = bench.slot("f" + std::to_string(i));
        EXPECT_EQ(slot.value, value::Value(1.0 + i));
        EXPECT_EQ(slot.quality, Quality::good);
        EXPECT_EQ(slot.batch, bench.slot("f9").batch);
    }
}

TEST(Polling, UngroupedTheTenRequestsOfTheSource) {
    auto ungrouped = device(16, scenario_1());
    ungrouped.group_requests = false;
    ungrouped.strategy = model::Strategy::single;
    Bench bench(project({ungrouped}));
    bench.run_until(99ms);
    ASSERT_EQ(bench.sent.size(), 10U);
    EXPECT_EQ(bench.sent[0].bytes, "10 03 00 00 00 02 C7 4A");
    EXPECT_EQ(bench.sent[9].bytes, "10 03 00 12 00 02 67 4F");
}

TEST(Polling, ARequestThatIsNeverAnsweredIsNotUrgentWhenItIsDueAgain) {
    auto first = device(1, {int16("silent", 0).read(3).every(10s), int16("alive", 500).read(3)});
    first.attempts = 2;
    Bench bench(project({first, device(2, {int16("x", 0).read(3).every(1s)})}));
    bench.players[1].silent_about = {0};
    bench.run_until(9990ms);
    bench.news();
    bench.run_until(10500ms);
    const auto sent = bench.news();
    ASSERT_GE(sent.size(), 3U);
    EXPECT_EQ(sent[0].start, 500);
    EXPECT_EQ(sent[1].unit, 2) << "its deadline is shorter";
    EXPECT_EQ(sent[2].unit, 1);
    EXPECT_EQ(sent[2].start, 0);
}

TEST(Polling, AResponseOfAnotherUnitIsNoSilence) {
    Bench bench(project({device(5, {int16("x", 0).read(3)})}));
    bench.players[5].answers_as = 1;
    bench.run_until(10s);
    const auto device = bench.master.line(0).device(0);
    EXPECT_EQ(device.state, DeviceState::not_answering);
    EXPECT_EQ(device.failure, Reason::unexpected_reply);
    EXPECT_EQ(device.foreign, device.counters.timeouts);
    EXPECT_EQ(device.last_foreign, (Mismatch{Mismatch::Part::unit, 1, 5}));
}

TEST(Polling, RoundsByAscendingAddressWaitForThePeriod) {
    auto described = project({device(9, {int16("c", 0).read(3)}), device(2, {int16("a", 0).read(3)}),
                              device(5, {int16("b", 0).read(3)})});
    described.lines[0].order = model::PollOrder::address;
    Bench bench(described);
    bench.run_until(350ms);
    ASSERT_EQ(bench.sent.size(), 12U);
    for (std::size_t i = 0; i < bench.sent.size(); ++i) {
        constexpr std::uint8_t kRound[] = {2, 5, 9};
        EXPECT_EQ(bench.sent[i].unit, kRound[i % 3]);
    }
    // On the grid, however long the round took: the link came up at 0, and t3.5 passed.
    for (std::size_t round = 1; round < 4; ++round)
        EXPECT_EQ(bench.sent[3 * round].t, at(static_cast<int>(round) * 100ms));
    EXPECT_TRUE(bench.observed.overruns.empty());
}

TEST(Polling, ARoundBeginsAtTheLowestAddressThatIsDue) {
    auto described =
        project({device(1, {int16("a", 0).read(3)}), device(3, {int16("b", 0).read(3).every(50ms)}),
                 device(5, {int16("c", 0).read(3)})});
    described.lines[0].order = model::PollOrder::address;
    Bench bench(described);
    bench.run_until(190ms);
    std::string units;
    for (const auto& request : bench.sent) units += static_cast<char>('0' + request.unit);
    EXPECT_EQ(units, "13531353");
}

TEST(Polling, ARoundLongerThanThePeriodGoesOnWithoutPause) {
    std::vector<model::Device> devices;
    for (int i = 1; i <= 4; ++i)
        devices.push_back(device(i, {int16("v" + std::to_string(i), 0).read(3).every(20ms)}));
    for (const auto order : {model::PollOrder::address, model::PollOrder::deadline}) {
        auto described = project(devices);
        described.lines[0].order = order;
        Bench bench(described);
        for (auto& [unit, player] : bench.players) player.turnaround = 10ms;
        bench.run_until(2s);
        for (std::size_t i = 1; i < bench.sent.size(); ++i) {
            EXPECT_LT(bench.sent[i].t - bench.sent[i - 1].t, 14ms);
        }
        // No request starves: each is sent in any round, or by deadline in any two.
        const std::size_t window = order == model::PollOrder::address ? 4 : 7;
        for (std::size_t i = window; i < bench.sent.size(); ++i) {
            std::set<std::uint8_t> units;
            for (std::size_t k = i - window; k < i; ++k) units.insert(bench.sent[k].unit);
            EXPECT_EQ(units.size(), 4U) << i;
        }
        for (std::size_t r = 0; r < 4; ++r)
            EXPECT_NEAR(static_cast<double>(bench.master.line(0).request(r).counters.sent),
                        static_cast<double>(bench.sent.size()) / 4, 2);
        ASSERT_FALSE(bench.observed.overruns.empty());
        EXPECT_EQ(bench.observed.overruns[0].first, 20ms);
        EXPECT_GT(bench.observed.overruns[0].second, 40ms);
        EXPECT_TRUE(bench.observed.overrun_flags[0]);
        EXPECT_TRUE(bench.master.line(0).request(2).overrun);
        EXPECT_GT(bench.master.line(0).request(2).skipped, 50U);
    }
}

TEST(Polling, TheShorterPeriodGoesFirst) {
    Bench bench(project({device(1, {int16("slow", 0).read(3).every(200ms)}),
                         device(2, {int16("fast", 0).read(3).every(50ms)}),
                         device(3, {int16("any", 0).read(3).every(0ms)})}));
    bench.run_until(60ms);
    const auto& sent = bench.sent;
    ASSERT_GE(sent.size(), 4U);
    EXPECT_EQ(sent[0].unit, 2);
    EXPECT_EQ(sent[1].unit, 1);
    EXPECT_EQ(sent[2].unit, 3);
    EXPECT_EQ(sent[3].unit, 3);  // as fast as the line allows
    for (std::size_t i = 1; i < sent.size(); ++i) EXPECT_LT(sent[i].t - sent[i - 1].t, 10ms);
}

// Slow requests of strategy optimal are spread over the rounds; their grid begins with the first link.
TEST(Polling, KeepsThePhasesOfThePlan) {
    auto described = project({device(1, {int16("fast", 0).read(3).every(50ms)}),
                              device(2, {int16("slow", 0).read(3).every(200ms)}),
                              device(3, {int16("other", 0).read(3).every(200ms)})});
    for (auto& device : described.lines[0].devices) device.strategy = model::Strategy::optimal;
    Bench bench(described);
    ASSERT_EQ(bench.plan.lines[0].requests[2].phase, 50ms);
    const auto starts = [&bench](Duration since) {
        std::vector<Duration> found;
        for (const auto& request : bench.news())
            if (request.unit == 3) found.push_back(request.t - at(since));
        return found;
    };
    const auto near = [](const std::vector<Duration>& found, const std::vector<Duration>& wanted) {
        ASSERT_EQ(found.size(), wanted.size());
        for (std::size_t i = 0; i < found.size(); ++i)
            EXPECT_TRUE(found[i] >= wanted[i] && found[i] < wanted[i] + 10ms);
    };
    bench.run_until(630ms);
    near(starts(0ms), {50ms, 250ms, 450ms});
    bench.link(false);
    bench.run_until(700ms);
    bench.link(true);
    bench.run_until(1130ms);
    near(starts(700ms), {0ms, 150ms, 350ms});  // overdue, then on the grid
}

TEST(Polling, AnExplicitDeadlineCountsInsteadOfThePeriod) {
    auto urgent = int16("urgent", 0).read(3).every(200ms);
    urgent.deadline = 20ms;
    Bench bench(project({device(1, {int16("fast", 0).read(3).every(50ms)}), device(2, {urgent})}));
    bench.run_until(30ms);
    ASSERT_GE(bench.sent.size(), 2U);
    EXPECT_EQ(bench.sent[0].unit, 2);
}

TEST(Polling, OneThatIsNotAnsweredDoesNotGoBeforeTheOthers) {
    Bench bench(project({device(1, {int16("a", 0).read(3)}), device(2, {int16("b", 0).read(3)}),
                         device(3, {int16("c", 0).read(3)})}));
    bench.players[1].dead = true;
    bench.run_until(150ms);
    ASSERT_GE(bench.sent.size(), 3U);
    EXPECT_EQ(bench.sent[0].unit, 1);
    EXPECT_EQ(bench.sent[1].unit, 2);  // after the time-out of the first
    EXPECT_EQ(bench.sent[2].unit, 3);
    EXPECT_GT(bench.sent[1].t, at(100ms));
    EXPECT_EQ(bench.slot("a").quality, Quality::never_read);
    EXPECT_EQ(bench.slot("a").reason, Reason::timeout);
}

TEST(Polling, ADeviceThatDoesNotAnswerIsProbedMoreAndMoreRarely) {
    Bench bench(
        project({device(1, {int16("a", 0).read(3).defaults_to(-7),
                            int16("b", 50).read(3).holding().defaults_to(-7), int16("d", 90).read(3)}),
                 device(2, {int16("c", 0).read(3)})},
                {local("status", DataType::int16)}));
    bench.players[1].registers = {{0, 5}, {50, 6}, {90, 7}};
    bench.run_until(950ms);
    EXPECT_EQ(bench.slot("a").value, value::Value(std::int64_t{5}));
    bench.players[1].dead = true;
    bench.run_until(3s);
    EXPECT_EQ(bench.master.line(0).device(0).state, DeviceState::not_answering);
    EXPECT_EQ(bench.slot("a").value, value::Value(std::int64_t{-7}));
    EXPECT_EQ(bench.slot("b").value, value::Value(std::int64_t{6}));  // holds the last
    EXPECT_EQ(bench.slot("d").value, value::Value(std::int64_t{7}));  // has no default
    for (const char* name : {"a", "b", "d"}) {
        EXPECT_EQ(bench.slot(name).quality, Quality::bad);
        EXPECT_EQ(bench.slot(name).reason, Reason::not_answering);
    }
    EXPECT_EQ(bench.slot("c").quality, Quality::good);

    bench.news();
    bench.run_until(300s);
    std::vector<Instant> probes;
    std::set<std::uint16_t> starts;
    for (const auto& request : bench.news())
        if (request.unit == 1) {
            probes.push_back(request.t);
            starts.insert(request.start);
        }
    EXPECT_EQ(starts.size(), 3U);  // in turns
    ASSERT_GE(probes.size(), 8U);
    for (std::size_t i = 2; i < probes.size(); ++i) {
        const auto wait = probes[i] - probes[i - 1];
        const auto before = probes[i - 1] - probes[i - 2];
        EXPECT_LT(wait, 60s + 300ms);
        EXPECT_GT(wait, std::min<Duration>(60s, 19 * before / 10 - 300ms)) << i;
    }
    EXPECT_EQ(bench.master.line(0).device(0).outages, 1U);

    bench.players[1].dead = false;
    bench.run_until(361s);
    EXPECT_EQ(bench.master.line(0).device(0).state, DeviceState::answering);
    for (const char* name : {"a", "b", "d"}) EXPECT_EQ(bench.slot(name).quality, Quality::good);
}

TEST(Polling, ADeviceThatDoesNotAnswerIsProbedOnRequest) {
    auto dying = device(1, {int16("a", 0).read(3).every(1s)});
    dying.response_timeout = 900ms;  // leaves no gap for an early probe
    Bench bench(project({dying, device(2, {int16("c", 0).read(3).every(200ms)})}));
    bench.players[1].dead = true;
    bench.run_until(100s);
    auto& line = bench.master.line(0);
    ASSERT_EQ(line.device(0).state, DeviceState::not_answering);
    ASSERT_TRUE(line.device(0).next_probe);
    EXPECT_GT(*line.device(0).next_probe, bench.now);
    EXPECT_GE(line.device(0).back_off, *line.device(0).next_probe - bench.now);
    EXPECT_FALSE(line.device(1).next_probe) << "it answers";
    bench.players[1].dead = false;
    bench.news();
    EXPECT_FALSE(line.probe_now(bench.now, 1)) << "it answers";
    EXPECT_TRUE(line.probe_now(bench.now, 0));
    bench.run_until(101s);
    EXPECT_EQ(line.device(0).state, DeviceState::answering);
    bench.link(false);
    EXPECT_FALSE(line.probe_now(bench.now, 0)) << "there is no link";
}

TEST(Polling, TheTimesOfEachRequestAreKept) {
    Bench bench(project({device(1, {int16("a", 0).read(3).every(100ms)})}));
    EXPECT_TRUE(bench.master.line(0).request_times(0).buckets.empty());
    bench.run_until(10s);
    const auto times = bench.master.line(0).request_times(0);
    const auto& exact = bench.master.line(0).request(0).counters.time;
    ASSERT_FALSE(times.buckets.empty());
    std::uint64_t count = 0;
    for (const auto& bucket : times.buckets) count += bucket.count;
    EXPECT_EQ(count, exact.count());
    EXPECT_GE(times.p50, exact.min());
    EXPECT_LE(times.p50, times.p99);
    EXPECT_LE(times.p99, exact.max());
}

TEST(Polling, ADeadDeviceCostsTheOthersOnlyItsProbes) {
    std::vector<model::Device> devices;
    for (int i = 1; i <= 5; ++i)
        devices.push_back(device(i, {int16("v" + std::to_string(i), 0).read(3).every(50ms)}));
    Bench bench(project(devices));
    bench.players[1].dead = bench.players[2].dead = true;
    bench.run_until(10s);
    bench.news();
    bench.run_until(70s);
    std::map<std::uint8_t, int> count;
    for (const auto& request : bench.news()) ++count[request.unit];
    EXPECT_LE(count[1] + count[2], 8);
    EXPECT_GE(count[5], 1200 - 8 * 3);  // 60 s / 50 ms, less at most three periods for a probe
}

// The line has a gap of 900 ms in each second, the time-out is 500 ms, the back-off has grown to 60 s.
TEST(Polling, ADeviceThatReturnsIsNoticedAtOnceWhereTheLineHasRoom) {
    auto dying = device(1, {int16("a", 0).read(3).every(1s), int16("b", 50).read(3).every(1s)});
    dying.response_timeout = 500ms;
    Bench bench(project({dying, device(2, {int16("c", 0).read(3).every(1s)})}));
    bench.players[1].dead = true;
    bench.run_until(3600s);
    EXPECT_EQ(bench.master.line(0).device(0).state, DeviceState::not_answering);
    bench.news();
    bench.run_until(3660s);
    int probes = 0;
    int late = 0;
    std::optional<Instant> before;
    for (const auto& request : bench.news()) {
        if (request.unit == 1) {
            ++probes;
            if (before) {
                EXPECT_GE(request.t - *before, 1s);
            }
            before = request.t;
        } else if ((request.t - Instant{}) % 1s > 10ms) {
            ++late;  // it waited for more than the other reads of its instant
        }
    }
    EXPECT_GE(probes, 50);
    EXPECT_LE(late, 1);  // at most the probe of the back-off
    for (int i = 0; i < 4; ++i) {
        const Duration back = 3700s + i * 100s + i * 270ms;
        bench.run_until(back);
        ASSERT_EQ(bench.master.line(0).device(0).state, DeviceState::not_answering);
        bench.players[1].dead = false;
        bench.run_until(back + 2s);
        EXPECT_EQ(bench.master.line(0).device(0).state, DeviceState::answering) << i;
        EXPECT_EQ(bench.slot("a").quality, Quality::good) << i;
        bench.players[1].dead = true;
    }
}

// No gap is as long as the time-out: only the back-off probes cost time, and the others keep their ages.
TEST(Polling, ASaturatedLineSendsNoProbeBeforeItsBackOff) {
    std::vector<model::Device> devices;
    for (int i = 1; i <= 4; ++i) {
        devices.push_back(device(i, {int16("v" + std::to_string(i), 0).read(3).every(100ms)}));
        devices.back().turnaround = 5ms;
        devices.back().response_timeout = 95ms;
        devices.back().response_timeout_set = true;
    }
    Bench bench(project(devices));
    bench.players[1].dead = true;
    bench.run_until(600s);
    bench.observed.sendings.clear();
    bench.news();
    bench.run_until(900s);
    for (const auto& sending : bench.observed.sendings) EXPECT_FALSE(sending.early);
    EXPECT_LE(std::ranges::count(bench.news(), 1, &Sent::unit), 6);
    for (const char* name : {"v2", "v3", "v4"}) EXPECT_EQ(bench.slot(name).quality, Quality::good);
    bench.players[1].dead = false;
    bench.run_until(962s);
    EXPECT_EQ(bench.master.line(0).device(0).state, DeviceState::answering);
}

// A back-off as long as the period is the pace of owen-kc1: one request in each period.
TEST(Polling, ABackOffNotLongerThanThePeriodIsThePaceOfTheProbes) {
    auto dying = device(1, {int16("a", 0).read(3).every(1s)});
    dying.backoff = model::Backoff{.first = 1s, .limit = 1s};
    Bench bench(project({dying}));
    bench.players[1].dead = true;
    bench.run_until(60s);
    bench.observed.sendings.clear();
    bench.news();
    bench.run_until(120s);
    EXPECT_LE(bench.news().size(), 60U);
    EXPECT_GE(bench.observed.sendings.size(), 50U);
    for (const auto& sending : bench.observed.sendings) EXPECT_FALSE(sending.early);
}

TEST(Polling, ARequestNeverAnsweredSlowsDownAlone) {
    Bench bench(
        project({device(1, {int16("good", 0).read(3), int16("silent", 50).read(3).defaults_to(-1)})}));
    bench.players[1].silent_about = {50};
    bench.run_until(20s);
    EXPECT_EQ(bench.slot("good").quality, Quality::good);
    EXPECT_EQ(bench.slot("silent").quality, Quality::bad);
    EXPECT_EQ(bench.slot("silent").reason, Reason::timeout);
    EXPECT_EQ(bench.slot("silent").value, value::Value(std::int64_t{-1}));
    EXPECT_EQ(bench.master.line(0).device(0).state, DeviceState::answering);
    bench.news();
    bench.run_until(140s);
    const auto news = bench.news();
    EXPECT_LE(std::count_if(news.begin(), news.end(), [](const Sent& s) { return s.start == 50; }), 8);
}

TEST(Polling, AnExceptionIsAnAnswer) {
    Bench bench(project({device(1, {int16("a", 0).read(3).reports_to(0), int16("b", 50).read(3)})},
                        {local("status", DataType::int16)}));
    bench.players[1].registers = {{0, 5}};
    bench.run_until(150ms);
    EXPECT_EQ(bench.status("status"), 0);
    bench.players[1].refuses = {{0, 2}};
    bench.news();
    bench.run_until(1050ms);
    EXPECT_EQ(bench.slot("a").quality, Quality::bad);
    EXPECT_EQ(bench.slot("a").reason, value::exception_reason(2));
    EXPECT_EQ(bench.slot("a").value, value::Value(std::int64_t{5}));
    EXPECT_EQ(bench.slot("b").quality, Quality::good);
    EXPECT_EQ(bench.status("status"), 2);
    EXPECT_EQ(bench.master.line(0).device(0).state, DeviceState::answering);
    EXPECT_EQ(bench.news().size(), 18U);  // no retries, no slowing down
    EXPECT_EQ(bench.master.line(0).statistics(bench.now).counters.exceptions_by_code[2], 9U);
}

TEST(Polling, ABusyDeviceIsGivenTime) {
    for (const std::uint8_t code : {std::uint8_t{5}, std::uint8_t{6}}) {
        Bench bench(project({device(1, {int16("a", 0).read(3)})}));
        bench.players[1].exception = code;
        bench.run_until(60s);
        EXPECT_EQ(bench.slot("a").reason, value::exception_reason(code));
        EXPECT_LE(bench.sent.size(), 14U);  // 100 ms doubling to 10 s
        EXPECT_GE(bench.sent.size(), 10U);
        bench.players[1].exception.reset();
        bench.run_until(72s);
        EXPECT_EQ(bench.slot("a").quality, Quality::good);
        bench.news();
        bench.run_until(73s);
        EXPECT_GE(bench.news().size(), 9U);
    }
}

TEST(Polling, AGatewayThatCannotReachItsDeviceIsNoAnswer) {
    Bench bench(project({device(1, {int16("a", 0).read(3)})}));
    bench.players[1].exception = 11;
    bench.run_until(2s);
    EXPECT_EQ(bench.master.line(0).device(0).state, DeviceState::not_answering);
    EXPECT_EQ(bench.slot("a").reason, Reason::not_answering);
}

TEST(Polling, StrangeExceptionCodesAreReported) {
    for (const auto& [code, status] : std::map<std::uint8_t, int>{{0, 256}, {0x7F, 383}, {0xFF, 511}}) {
        Bench bench(
            project({device(1, {int16("a", 0).read(3).reports_to(0)})}, {local("status", DataType::int16)}));
        bench.players[1].exception = code;
        bench.run_until(50ms);
        EXPECT_EQ(bench.status("status"), status);
    }
}

TEST(Polling, StatusHasTheCauseOfAFailure) {
    auto watched = device(1, {int16("a", 0).read(3)});
    watched.status = 0;
    watched.poll_enable = 1;
    Bench bench(project({watched}, {local("status", DataType::int16), local("on")}));
    bench.run_until(50ms);
    EXPECT_TRUE(bench.sent.empty());  // switched off by the local's value
    ASSERT_TRUE(bench.set("on", true));
    bench.run_until(150ms);
    EXPECT_EQ(bench.status("status"), 0);
    bench.players[1].dead = true;
    bench.run_until(400ms);
    EXPECT_EQ(bench.status("status"), 100);
    EXPECT_EQ(bench.slot("a").quality, Quality::uncertain);
    bench.run_until(2s);
    EXPECT_EQ(bench.status("status"), 105);
    bench.players[1].dead = false;
    bench.run_until(10s);
    EXPECT_EQ(bench.status("status"), 0);
    ASSERT_TRUE(bench.set("on", false));
    EXPECT_EQ(bench.status("status"), 104);
    EXPECT_EQ(bench.slot("a").reason, Reason::switched_off);
    bench.run_until(10050ms);
    bench.news();
    bench.run_until(20s);
    EXPECT_TRUE(bench.news().empty());
    ASSERT_TRUE(bench.set("on", true));
    bench.run_until(20050ms);
    EXPECT_EQ(bench.slot("a").quality, Quality::good);
    bench.link(false);
    EXPECT_EQ(bench.status("status"), 103);
    EXPECT_EQ(bench.slot("a").quality, Quality::bad);
    EXPECT_EQ(bench.master.line(0).next_wakeup(), kNever);
    bench.run_until(30s);
    bench.link(true);
    bench.run_until(30050ms);
    EXPECT_EQ(bench.status("status"), 0);
    EXPECT_EQ(bench.slot("a").quality, Quality::good);
}

// A status variable has one number for both (docs/specification.md, section 7).
TEST(Polling, APortThatNeverOpenedWasNotLost) {
    auto described = project({device(1, {int16("a", 0).read(3)})}, {local("status", DataType::int16)});
    described.lines[0].devices[0].variables[0].status = 0;
    const auto plan = plan::make_plan(described);
    Master master(described, plan);
    const auto slot = [&](const char* name) { return master.store()[*master.store().find(name)]; };
    for (const bool up : {false, false, true, false}) {
        const bool was_up = master.line(0).was_up();
        master.line(0).on_link(Instant{1s}, up);
        if (up) continue;
        EXPECT_EQ(slot("a").reason, was_up ? Reason::link_lost : Reason::never_connected);
        EXPECT_EQ(slot("status").value, value::Value(std::int64_t{103}));
        EXPECT_EQ(master.line(0).device(0).state, DeviceState::link_down);
    }
    EXPECT_TRUE(master.line(0).was_up());
}

TEST(Polling, ATriggerReadsOnceBeforeThePolling) {
    Bench bench(project({device(1, {int16("slow", 0).read(3).every(10s)}),
                         device(2, {int16("asked", 0).read(3).every(10s).read_on(0)}),
                         device(3, {int16("busy", 0).read(3).every(0ms)})},
                        {local("go")}));
    bench.run_until(1s);
    bench.news();
    ASSERT_TRUE(bench.set("go", true));
    bench.run_until(1020ms);
    const auto news = bench.news();
    ASSERT_GE(news.size(), 2U);
    EXPECT_TRUE(news[0].unit == 2 || news[1].unit == 2);  // at most the one in flight goes before
    ASSERT_TRUE(bench.set("go", true));                   // no edge
    bench.run_until(2s);
    ASSERT_TRUE(bench.set("go", false));
    bench.run_until(3s);
    for (const auto& request : bench.news()) EXPECT_EQ(request.unit, 3);
}

TEST(Polling, StatisticsMeasureWhatThePlanPromised) {
    auto described = project(
        {device(1, {int16("a", 0).read(3), int16("b", 50).read(3)}), device(2, {int16("c", 0).read(4)})});
    for (auto& device : described.lines[0].devices) device.turnaround = 3ms;
    Bench bench(described);
    bench.run_until(10050ms);
    const auto statistics = bench.master.line(0).statistics(bench.now);
    EXPECT_EQ(statistics.counters.sent, 303U);
    EXPECT_EQ(statistics.counters.answered, 303U);
    EXPECT_EQ(statistics.planned_cycle, bench.plan.lines[0].cycle);
    EXPECT_GT(statistics.measured_cycle, statistics.planned_cycle - 10us);
    EXPECT_LT(statistics.measured_cycle, statistics.planned_cycle + 10us);
    EXPECT_NEAR(statistics.utilization, bench.plan.lines[0].utilization, 0.02);
    EXPECT_EQ(bench.master.line(0).device(0).counters.answered, 202U);
    EXPECT_EQ(bench.master.line(0).request(2).counters.answered, 101U);
    EXPECT_EQ(bench.master.line(0).request(2).real_period.max(), 100ms);
}

TEST(Polling, AJabberingStationMakesDevicesNotAnswer) {
    Bench bench(project({device(1, {int16("a", 0).read(3)}), device(2, {int16("b", 0).read(3)})}));
    const std::uint8_t noise[] = {0x55};
    for (Duration t = 1ms; t < 5s; t += 1ms) {
        bench.run_until(t);
        bench.master.line(0).on_bytes(bench.now, noise);
    }
    EXPECT_TRUE(bench.sent.empty());
    EXPECT_EQ(bench.slot("a").reason, Reason::not_answering);
    EXPECT_EQ(bench.slot("b").reason, Reason::not_answering);
}

// RecordingObserver right before each request goes out; its contents are named.
TEST(Polling, EachRequestIsReportedWithItsPurpose) {
    auto described =
        project({device(1, {int16("a", 0).read(3).read_on(0), int16("b", 1).read(3).write(0x06),
                            boolean("c", 2, 3).write(0x06), int16("d", 9).write(0x10).verified()})},
                {local("go")});
    auto& one = described.lines[0].devices[0];
    one.attempts = 2;
    one.read_modify_write = true;
    Bench bench(described);
    const auto sent_until = [&](Duration until) {
        bench.observed.sendings.clear();
        bench.run_until(until);
        std::vector<std::string> names;
        for (const auto& sending : bench.observed.sendings) {
            auto text = std::string(name(sending.purpose));
            if (sending.command) text += " " + std::to_string(*sending.command);
            EXPECT_NE(sending.command.has_value(), sending.request.has_value()) << text;
            names.push_back(text);
        }
        return names;
    };
    using Names = std::vector<std::string>;
    sent_until(50ms);
    ASSERT_TRUE(bench.set("go", true));
    EXPECT_EQ(sent_until(90ms), Names{"trigger"});
    sent_until(120ms);
    ASSERT_TRUE(bench.write(7, "b", std::int64_t{5}));
    ASSERT_TRUE(bench.write(8, "c", true));
    ASSERT_TRUE(bench.write(9, "d", std::int64_t{6}));
    EXPECT_EQ(sent_until(180ms), (Names{"write 7", "before_write 8", "write 8", "write 9", "read_back 9"}));
    bench.players[1].dead = true;
    const auto failing = sent_until(20s);
    ASSERT_GE(failing.size(), 4U);
    EXPECT_EQ(failing[0], "period");
    EXPECT_EQ(failing[1], "repetition");
    for (std::size_t i = 2; i < failing.size(); ++i) EXPECT_EQ(failing[i], "probe") << i;
}

}  // namespace polling_test
}  // namespace takt::poll
