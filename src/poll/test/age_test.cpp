// Quality follows time: a good value that is not read any more becomes stale, once, when its greatest age
// passes.
#include <gtest/gtest.h>

#include <random>

#include "bench.hpp"
#include "takt/plan/proof.hpp"

namespace takt::poll {
namespace age_test {

using namespace test;
using value::Quality;
using value::Reason;

/// Plans with the proved ages.
struct Proved : Bench {
    explicit Proved(const model::Project& described)
        : Bench(described, plan::prove(described, false, false).plan) {
        for (auto& [unit, player] : players) player.turnaround = 3ms;
    }
    [[nodiscard]] Duration age(std::size_t device, std::size_t variable) const {
        return plan.lines[0].ages.at(device).at(variable).value();
    }
    /// The changes of quality of a variable so far, after the first good one.
    std::vector<std::pair<Instant, Quality>> changes(const std::string& name) {
        std::vector<std::pair<Instant, Quality>> all;
        value::EventCursor cursor;
        while (const auto* event = master.store().next_event(cursor)) {
            if (event->slot != id(name) || (all.empty() && event->quality != Quality::good)) continue;
            if (!all.empty() && all.back().second == event->quality) continue;
            EXPECT_EQ(event->reason == Reason::stale, event->quality == Quality::uncertain);
            all.emplace_back(event->t, event->quality);
        }
        return all;
    }
};

model::Device calm(int address, const std::vector<Item>& items) {
    auto made = device(address, items);
    made.turnaround = 3ms;
    return made;
}

Instant last_read(const Bench& bench, std::uint16_t start) {
    Instant last;
    for (const auto& sent : bench.sent)
        if (sent.function == 3 && sent.start == start) last = sent.t;
    return last;
}

// The line is up, but polling stops.
TEST(Ages, AValueThatIsNotReadAnyMoreBecomesStaleAtItsProvedAge) {
    Proved bench(
        project({calm(1, {int16("a", 0).read(3).every(100ms), int16("b", 50).read(3).every(500ms)})}));
    bench.run_until(2s);
    EXPECT_EQ(bench.changes("a").size(), 1U);
    bench.master.line(0).hold();
    bench.run_until(10s);
    for (const auto& [name, start, index] : {std::tuple("a", 0, 0), std::tuple("b", 50, 1)}) {
        const auto changes = bench.changes(name);
        ASSERT_EQ(changes.size(), 2U) << name << ": one event";
        EXPECT_EQ(changes[1].second, Quality::uncertain);
        EXPECT_EQ(changes[1].first, last_read(bench, static_cast<std::uint16_t>(start)) +
                                        bench.age(0, static_cast<std::size_t>(index)) + 1ns);
        EXPECT_EQ(bench.slot(name).reason, Reason::stale);
        EXPECT_FALSE(value::is_empty(bench.slot(name).value)) << "the value stays";
        EXPECT_EQ(bench.master.line(0).request(static_cast<std::size_t>(index)).late_refreshes, 1U);
    }
}

TEST(Ages, AGoodReadMakesItGoodAgain) {
    auto described = project({calm(1, {int16("a", 0).read(3).every(100ms)})}, {local("st", DataType::int16)});
    described.lines[0].devices[0].variables[0].status = 0;
    Proved bench(described);
    bench.run_until(950ms);
    // The host stands still: nothing happens for a while.
    bench.now = at(3s);
    bench.master.line(0).on_tick(bench.now);
    EXPECT_EQ(bench.slot("a").reason, Reason::stale);
    EXPECT_EQ(bench.status("st"), 108);
    bench.run_until(4s);
    EXPECT_EQ(bench.slot("a").quality, Quality::good);
    EXPECT_EQ(bench.status("st"), 0);
    EXPECT_EQ(bench.changes("a").size(), 3U);
}

TEST(Ages, MaxAgeCountsWhereNoAgeIsProved) {
    auto fast = int16("fast", 0).read(3).every(0ms);
    fast.max_age = 700ms;
    auto none = int16("none", 50).read(3).every(0ms);
    auto proved = int16("proved", 90).read(3).every(100ms);
    proved.max_age = 5s;
    Proved bench(project({calm(1, {fast, none, proved})}));
    bench.run_until(1s);
    bench.master.line(0).hold();
    bench.run_until(10s);
    EXPECT_EQ(bench.changes("fast").at(1).first, last_read(bench, 0) + 700ms + 1ns);
    EXPECT_EQ(bench.changes("none").size(), 1U);
    EXPECT_EQ(bench.changes("proved").at(1).first, last_read(bench, 90) + bench.age(0, 2) + 1ns);
}

TEST(Ages, ALineThatDoesNotHoldItsDeadlinesHasNoProvedAge) {
    std::vector<model::Device> devices;
    for (int d = 1; d <= 5; ++d)
        devices.push_back(calm(d, {int16("v" + std::to_string(d), 0).read(3).every(20ms)}));
    Proved bench(project(devices));
    EXPECT_TRUE(bench.plan.lines[0].ages.empty());
    bench.run_until(2s);
    bench.master.line(0).hold();
    bench.run_until(10s);
    EXPECT_EQ(bench.slot("v1").quality, Quality::good);
}

TEST(Ages, WhatIsSwitchedOffOrLostKeepsItsReason) {
    auto described = project(
        {calm(1, {int16("a", 0).read(3).every(100ms)}), calm(2, {int16("b", 0).read(3).every(100ms)})},
        {local("on")});
    described.lines[0].devices[0].poll_enable = 0;
    Proved bench(described);
    ASSERT_TRUE(bench.set("on", true));
    bench.run_until(1s);
    ASSERT_TRUE(bench.set("on", false));
    bench.run_until(5s);
    EXPECT_EQ(bench.slot("a").reason, Reason::switched_off);
    bench.link(false);
    bench.run_until(10s);
    EXPECT_EQ(bench.slot("b").reason, Reason::link_lost);
}

// Reading back one value of a request proves nothing about its others.
TEST(Ages, AVerifiedWriteKeepsOnlyItsOwnValueFresh) {
    auto described = project({calm(
        1, {int16("a", 0).read(3).every(100ms), int16("w", 1).read(3).write(6).every(100ms).verified()})});
    Proved bench(described);
    ASSERT_EQ(bench.plan.lines[0].requests.size(), 1U);
    bench.run_until(1s);
    bench.master.line(0).hold();
    bench.after_each = [&bench, sent = std::uint64_t{0}]() mutable {
        if (sent > bench.outcomes.size()) return;
        ++sent;
        ASSERT_TRUE(bench.write(sent, "w", std::int64_t(sent % 1000), 1h));
    };
    bench.run_until(5s);
    ASSERT_GT(bench.outcomes.size(), 10U);
    EXPECT_EQ(bench.slot("a").reason, Reason::stale);
    EXPECT_EQ(bench.slot("w").quality, Quality::good);
    bench.after_each = {};
    bench.run_until(10s);
    EXPECT_EQ(bench.slot("w").reason, Reason::stale);
}

// A value that was read back is as old as its request, also when the response came late.
TEST(Ages, AValueReadBackCountsFromTheStartOfItsTransaction) {
    auto w = int16("w", 1).read(3).write(6).every(0ms).verified();
    w.max_age = 2s;
    auto slow = device(1, {w});
    slow.response_timeout = 1s;
    Proved bench(project({slow}));
    bench.run_until(1s);
    bench.master.line(0).hold();
    bench.players[1].turnaround = 900ms;
    ASSERT_TRUE(bench.write(1, "w", std::int64_t{7}));
    bench.run_until(10s);
    ASSERT_EQ(bench.outcomes.size(), 1U);
    EXPECT_EQ(bench.outcomes[0].result, value::CommandResult::done);
    const auto changes = bench.changes("w");
    ASSERT_EQ(changes.size(), 2U);
    EXPECT_EQ(changes[1].first, last_read(bench, 1) + 2s + 1ns);
}

// On a line that holds its deadlines no value is ever stale.
TEST(Ages, NothingIsStaleOnAHealthyLine) {
    std::mt19937 random(23);
    int feasible = 0;
    for (int round = 0; round < 60; ++round) {
        std::vector<model::Device> devices;
        std::vector<std::string> names;
        for (int d = 1; d <= 1 + static_cast<int>(random() % 4); ++d) {
            constexpr Duration kPeriods[] = {50ms, 100ms, 150ms, 240ms, 500ms, 1000ms};
            std::vector<Item> items;
            for (int i = 0; i <= static_cast<int>(random() % 4); ++i) {
                names.push_back("v" + std::to_string(d) + "_" + std::to_string(i));
                items.push_back(int16(names.back(), 40 * i).read(3).every(kPeriods[random() % 6]));
                if (random() % 3 == 0) items.back().deadline = items.back().period * 2;
            }
            devices.push_back(calm(d, items));
            if (random() % 3 == 0) devices.back().turnaround.reset();
            if (random() % 3 == 0) devices.back().strategy = model::Strategy::optimal;
        }
        auto described = project(devices);
        if (random() % 3 == 0) described.lines[0].order = model::PollOrder::address;
        Proved bench(described);
        if (bench.plan.lines[0].ages.empty()) continue;
        ++feasible;
        bench.run_until(3s);
        value::EventCursor cursor;
        while (const auto* event = bench.master.store().next_event(cursor))
            EXPECT_NE(event->reason, Reason::stale) << "round " << round;
        bench.master.line(0).hold();
        bench.run_until(60s);
        for (const auto& name : names) EXPECT_EQ(bench.slot(name).reason, Reason::stale) << "round " << round;
    }
    EXPECT_GT(feasible, 20);
}

TEST(Overruns, AreReportedWhileTheyLast) {
    Bench bench(project({calm(1, {int16("a", 0).read(3).every(100ms)})}));
    bench.run_until(1s);
    bench.master.line(0).hold();
    bench.run_until(10s);
    ASSERT_EQ(bench.observed.overrun_flags, std::vector<bool>{true});
    EXPECT_EQ(bench.observed.overruns[0].first, Duration(100ms));
    EXPECT_EQ(bench.observed.overruns[0].second, Duration(420ms) + 1ns);
    EXPECT_TRUE(bench.master.line(0).request(0).overrun);
    EXPECT_TRUE(bench.master.line(0).variable(0, 0).overrun);
}

}  // namespace age_test
}  // namespace takt::poll
