// gaps: learn on a line: the values stay fresh while gaps are tried, and the plan becomes the best one.
#include <gtest/gtest.h>

#include <random>

#include "bench.hpp"
#include "takt/model/item_ranges.hpp"
#include "takt/plan/guarantee.hpp"

namespace takt::poll {
namespace learning_line_test {

using namespace test;
using model::ItemRange;
using model::ItemRanges;
using value::Quality;

constexpr auto kHolding = static_cast<std::size_t>(wire::Area::holding_register);

model::Device learning(std::vector<Item> items, int address = 1) {
    auto made = device(address, items);
    made.strategy = model::Strategy::optimal;
    made.gaps = model::Gaps::learn;
    made.registers_per_request_set = false;
    made.turnaround = 4ms;
    return made;
}

std::vector<Item> ladder(int count, int step, Duration period = 100ms) {
    std::vector<Item> items;
    for (int i = 0; i < count; ++i)
        items.push_back(int16("v" + std::to_string(i), i * step).read(3).every(period));
    return items;
}

/// Reads as "start+quantity" of the plan that runs.
std::vector<std::string> reads(const Bench& bench) {
    std::vector<std::string> all;
    for (const auto& request : bench.master.line(0).plan().requests)
        if (request.read)
            all.push_back(std::to_string(request.start) + "+" + std::to_string(request.quantity));
    return all;
}

ItemRanges refused(const Bench& bench, std::size_t device = 0) {
    ItemRanges ranges;
    const auto learnt = bench.master.line(0).learnt(bench.now);
    for (const auto& range : learnt[device].refused[kHolding]) ranges.push_back(range.items);
    return ranges;
}

std::size_t touching(const std::vector<Sent>& sent, const ItemRange& items) {
    return static_cast<std::size_t>(std::ranges::count_if(sent, [&](const Sent& s) {
        return s.quantity > 0 && s.start <= items.last && items.first < s.start + s.quantity;
    }));
}

/// Runs and sees to it that no value of the line is ever anything but good, once all were read.
void stay_good(Bench& bench, Duration until) {
    value::EventCursor cursor;
    while (bench.master.store().next_event(cursor)) {}
    bench.run_until(until);
    while (const auto* event = bench.master.store().next_event(cursor))
        EXPECT_EQ(event->quality, Quality::good)
            << bench.master.store().info(event->slot).name << " at " << (event->t - Instant{}) / 1ms;
}

TEST(LearningLine, AGoodDeviceIsReadInOneRequestAfterOneTrial) {
    Bench bench(project({learning(ladder(8, 5))}));
    EXPECT_EQ(reads(bench).size(), 8U) << "nothing is confirmed yet";
    bench.run_until(90ms);
    stay_good(bench, 2s);
    EXPECT_EQ(reads(bench), std::vector<std::string>{"0+36"});
    EXPECT_LE(touching(bench.sent, {1, 4}), 1 + 20U) << "one trial, then each period";
}

TEST(LearningLine, OnlyTheBadGapIsGivenUpAndNoValueGoesBad) {
    Bench bench(project({learning(ladder(8, 5))}));
    bench.players[1].lacks = {{12, 12}};
    bench.run_until(90ms);
    stay_good(bench, 5s);
    EXPECT_EQ(reads(bench), (std::vector<std::string>{"0+11", "15+21"}));
    EXPECT_EQ(refused(bench), (ItemRanges{{11, 14}}));
    EXPECT_LE(touching(bench.sent, {12, 12}), 7U);
    bench.news();
    bench.run_until(50min);
    EXPECT_EQ(touching(bench.news(), {12, 12}), 0U) << "left alone";
    bench.run_until(70min);
    EXPECT_EQ(touching(bench.news(), {12, 12}), 1U) << "asked again after an hour";
    EXPECT_EQ(refused(bench), (ItemRanges{{11, 14}}));
}

TEST(LearningLine, EachExceptionThatMeansNoIsUnderstood) {
    for (const int code : {1, 2, 3, 4}) {
        Bench bench(project({learning(ladder(6, 4))}));
        bench.players[1].lacks = {{5, 6}, {17, 17}};
        bench.players[1].refusal = static_cast<std::uint8_t>(code);
        bench.run_until(5s);
        EXPECT_EQ(refused(bench), (ItemRanges{{5, 7}, {17, 19}})) << code;
        EXPECT_EQ(reads(bench), (std::vector<std::string>{"0+5", "8+9", "20+1"})) << code;
    }
}

TEST(LearningLine, ABusyDeviceIsNotBlamed) {
    Bench bench(project({learning(ladder(6, 4))}));
    bench.players[1].lacks = {{5, 6}};
    bench.players[1].refusal = 6;
    bench.run_until(20s);
    EXPECT_EQ(refused(bench), ItemRanges{});
    EXPECT_EQ(bench.slot("v1").quality, Quality::good);
}

TEST(LearningLine, AGapThatSilencesTheDeviceDoesNotMakeItDead) {
    auto silent = learning(ladder(6, 4));
    silent.attempts = 1;
    Bench bench(project({silent}));
    bench.players[1].chokes_on = {{5, 6}};
    bench.run_until(300s);
    EXPECT_EQ(refused(bench), ItemRanges{});
    EXPECT_EQ(reads(bench), (std::vector<std::string>{"0+5", "8+13"}));
    EXPECT_EQ(bench.master.line(0).device(0).outages, 0U);
    EXPECT_LE(touching(bench.sent, {5, 6}), 12U);
}

TEST(LearningLine, ADeviceThatIsWrongNowAndThenKeepsItsGroups) {
    Bench bench(project({learning(ladder(8, 5))}));
    std::mt19937 random(11);
    bench.players[1].refuses_now = [&random] { return random() % 12 == 0; };
    bench.run_until(120s);
    EXPECT_EQ(refused(bench), ItemRanges{});
    EXPECT_EQ(reads(bench), std::vector<std::string>{"0+36"});
}

// Its firmware changed, or it was replaced: it refuses items from now on that it gave before.
TEST(LearningLine, AConfirmedGapThatTurnsBadIsGivenUpLater) {
    Bench bench(project({learning(ladder(8, 5))}));
    bench.run_until(2s);
    ASSERT_EQ(reads(bench).size(), 1U);
    bench.players[1].lacks = {{22, 23}};
    bench.run_until(2500ms);
    for (int i = 0; i < 8; ++i) {
        const auto& slot = bench.slot("v" + std::to_string(i));
        EXPECT_EQ(slot.quality, Quality::good) << i;
        EXPECT_GE(*slot.good_at, at(2400ms)) << i;
    }
    bench.run_until(10s);
    EXPECT_EQ(refused(bench), (ItemRanges{{21, 24}}));
    EXPECT_EQ(reads(bench), (std::vector<std::string>{"0+21", "25+11"}));
}

TEST(LearningLine, AVariableThatIsRefusedItselfBlamesNoGap) {
    Bench bench(project({learning(ladder(8, 5))}));
    bench.players[1].lacks = {{10, 10}};
    bench.run_until(60s);
    EXPECT_EQ(bench.slot("v2").quality, Quality::bad);
    EXPECT_EQ(refused(bench), ItemRanges{});
    EXPECT_EQ(reads(bench), (std::vector<std::string>{"0+6", "10+1", "15+21"}));
    EXPECT_EQ(bench.slot("v7").quality, Quality::good);
}

TEST(LearningLine, ADeviceThatTakesShortReadsOnlyIsReadSo) {
    Bench bench(project({learning(ladder(12, 5))}));
    bench.players[1].most_items = 20;
    bench.run_until(60s);
    EXPECT_EQ(refused(bench), ItemRanges{});
    for (const auto& request : bench.master.line(0).plan().requests) EXPECT_LE(request.quantity, 20);
    EXPECT_LE(reads(bench).size(), 6U);
    EXPECT_EQ(bench.slot("v11").quality, Quality::good);
}

TEST(LearningLine, AnOverloadedLineLearnsToo) {
    Bench bench(project({learning(ladder(20, 3, 40ms))}));
    ASSERT_GT(bench.master.line(0).plan().utilization, 1);
    bench.players[1].lacks = {{31, 31}};
    bench.run_until(120s);
    EXPECT_EQ(refused(bench), (ItemRanges{{31, 32}}));
    EXPECT_EQ(reads(bench).size(), 2U);
}

TEST(LearningLine, WithPeriodZeroTrialsTakeTurnsWithPolling) {
    Bench bench(project({learning(ladder(6, 4, 0ms))}));
    bench.players[1].lacks = {{5, 6}};
    bench.run_until(10s);
    EXPECT_EQ(reads(bench), (std::vector<std::string>{"0+5", "8+13"}));
}

TEST(LearningLine, ADeadDeviceIsNotTried) {
    Bench bench(project({learning(ladder(6, 4)), learning({int16("other", 0).read(3)}, 2)}));
    bench.players[1].dead = true;
    bench.run_until(30s);
    EXPECT_EQ(touching(bench.sent, {1, 3}), 0U);
    bench.players[1].dead = false;
    bench.run_until(100s);
    EXPECT_EQ(reads(bench), (std::vector<std::string>{"0+21", "0+1"}));
}

// The device stops answering while the plan changes.
TEST(LearningLine, ANewPlanSendsNoProbeWithinThePeriod) {
    bool any = false;
    for (Duration dies = 20ms; dies < 2500ms; dies += 20ms) {
        auto dying = learning(ladder(6, 4, 1s));
        dying.attempts = 1;
        Bench bench(project({dying}));
        bench.run_until(dies);
        bench.players[1].dead = true;
        bench.run_until(10s);
        ASSERT_EQ(bench.observed.sendings.size(), bench.sent.size());
        Instant last_read = Instant::min();
        for (std::size_t i = 0; i < bench.sent.size(); ++i) {
            const auto& sending = bench.observed.sendings[i];
            if (sending.purpose == Purpose::trial) continue;
            if (sending.early) {
                EXPECT_GE(bench.sent[i].t, after(last_read, 1s)) << dies / 1ms;
                any = true;
            }
            last_read = bench.sent[i].t;
        }
    }
    EXPECT_TRUE(any);
}

TEST(LearningLine, WritesAndTriggersThatWaitOutliveThePlan) {
    auto items = ladder(6, 4, 1s);
    items[2] = items[2].write(0x10).on_change().admitted(3s, 1);
    items[3] = items[3].write(0x10);
    items[4] = items[4].read_on(0);
    auto described = project({learning(items)}, {local("go")});
    described.locals[0].admission = model::RateLimit{3s, 1};
    Bench bench(described);
    bench.run_until(5ms);
    ASSERT_TRUE(bench.set("v2", std::int64_t{1}));
    ASSERT_TRUE(bench.set("go", true));
    bench.run_until(30ms);
    ASSERT_TRUE(bench.set("go", false));
    ASSERT_TRUE(bench.set("v2", std::int64_t{7}));
    ASSERT_TRUE(bench.set("go", true));
    ASSERT_TRUE(bench.write(1, "v3", std::int64_t{9}));
    ASSERT_GT(reads(bench).size(), 2U);
    bench.run_until(2s);
    ASSERT_LE(reads(bench).size(), 2U) << "another plan";
    EXPECT_EQ(bench.players[1].registers[8], 1) << "held back";
    EXPECT_EQ(bench.players[1].registers[12], 9);
    bench.news();
    bench.run_until(5s);
    EXPECT_EQ(bench.players[1].registers[8], 7);
    std::size_t alone = 0;
    for (const auto& sent : bench.news()) alone += sent.start == 16 && sent.quantity == 1 ? 1U : 0U;
    EXPECT_EQ(alone, 1U) << "read by its trigger, as soon as that is admitted";
    ASSERT_EQ(bench.outcomes.size(), 1U);
    EXPECT_EQ(bench.outcomes[0].result, value::CommandResult::done);
}

TEST(LearningLine, WithoutLearningExactlyThePlanIsRun) {
    auto described = project({learning(ladder(6, 4))});
    const auto plan = plan::make_plan(described);
    const value::ProjectSlots slots(described);
    value::Store store(value::slot_infos(described));
    LinePoller poller(described, plan.lines[0], slots, store, {.learn = false});
    EXPECT_EQ(&poller.plan(), &plan.lines[0]);
    EXPECT_FALSE(poller.learns());
}

// While gaps are tried and given up, every value is as fresh as what is proved of the project from the start.
TEST(LearningLine, NoValueIsOlderThanItsGuarantee) {
    std::mt19937 random(5);
    int feasible = 0;
    for (int round = 0; round < 40; ++round) {
        std::vector<model::Device> devices;
        for (int d = 1; d <= 1 + static_cast<int>(random() % 3); ++d) {
            std::vector<Item> items;
            int next = 0;
            for (int i = 2 + static_cast<int>(random() % 8); i > 0;
                 --i, next += 1 + static_cast<int>(random() % 6))
                items.push_back(int16("v" + std::to_string(d) + "_" + std::to_string(i), next)
                                    .read(3)
                                    .every(random() % 3 == 0 ? 240ms : 80ms));
            devices.push_back(learning(items, d));
        }
        auto described = project(devices);
        const auto proved = plan::guarantee(described, plan::make_plan(described)).at(0);
        if (!proved.feasible) continue;
        ++feasible;
        Bench bench(described);
        for (auto& [unit, player] : bench.players) {
            player.turnaround = 4ms;
            for (int i = 0; i < 2; ++i) {
                const auto bad = static_cast<std::uint16_t>(random() % 40);
                const auto& variables = described.lines[0].devices[unit - 1U].variables;
                if (std::ranges::none_of(variables, [&](const auto& v) { return v.register_number == bad; }))
                    player.lacks.push_back({bad, bad});
            }
        }
        bench.run_until(400ms);
        Duration worst = Duration::min();
        for (Duration t = 400ms; t < 6s; t += 1ms) {
            bench.run_until(t);
            for (std::size_t d = 0; d < described.lines[0].devices.size(); ++d)
                for (std::size_t v = 0; v < described.lines[0].devices[d].variables.size(); ++v) {
                    const auto& slot = bench.master.store()[bench.master.slots().variable({0, d, v})];
                    worst = std::max(worst, bench.now - *slot.good_at - *proved.ages[d][v]);
                }
        }
        EXPECT_LE(worst, 0ms) << "round " << round;
        for (std::size_t d = 0; d < described.lines[0].devices.size(); ++d)
            for (const auto& bad : refused(bench, d))
                EXPECT_TRUE(std::ranges::any_of(bench.players[static_cast<std::uint8_t>(d + 1)].lacks,
                                                [&](const auto& l) { return model::overlap(l, bad); }))
                    << "round " << round;
    }
    EXPECT_GT(feasible, 20);
}

}  // namespace learning_line_test
}  // namespace takt::poll
