// Results of trials without a line: the device is a set of items, time is a number.
#include "learning/learning.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <bit>
#include <random>
#include <set>

#include "bench.hpp"

namespace takt::poll {
namespace learning_test {

using namespace test;
using model::ItemRange;
using model::ItemRanges;

constexpr auto kHolding = static_cast<std::size_t>(wire::Area::holding_register);

struct AllGood final : FreshnessProbe {
    Freshness freshness(std::size_t, wire::Function, const ItemRange&, Instant) const override {
        return Freshness::good;
    }
};

model::Project described(const std::vector<int>& registers) {
    std::vector<Item> items;
    for (const int number : registers) items.push_back(int16("v" + std::to_string(number), number).read(3));
    auto made = project({device(1, items)});
    auto& learning = made.lines[0].devices[0];
    learning.strategy = model::Strategy::optimal;
    learning.gaps = model::Gaps::learn;
    return made;
}

/// A device that is asked until nothing is left to be tried.
struct Trying {
    explicit Trying(model::Project of) : project(std::move(of)), learning(project.lines[0]) { replan(); }

    /// @returns how many questions it took
    std::size_t run(Duration until, auto answer) {
        std::size_t asked = 0;
        const AllGood probe;
        while (now <= at(until)) {
            if (learning.wants_plan(now)) replan();
            if (const auto trial_read = learning.next(now, probe)) {
                ++asked;
                learning.asked();
                answer(*trial_read);
                now += 10ms;
            } else if (!learning.wants_plan(now)) {
                now = learning.wakeup(now);
            }
        }
        return asked;
    }
    void replan() {
        auto made = plan::learning_plan(project, 0, learning.learnt(now));
        plan = made.plan;
        learning.plan_is_made();
        learning.set_trials(now, made.trials);
    }
    [[nodiscard]] ItemRanges refused() const {
        ItemRanges ranges;
        const auto learnt = learning.learnt(now);
        for (const auto& range : learnt[0].refused[kHolding]) ranges.push_back(range.items);
        return ranges;
    }
    void take_answer(const Learning::TrialRead& trial_read, const ItemRanges& bad, bool refuses = false) {
        const auto last =
            static_cast<std::uint16_t>(trial_read.read.start.value + trial_read.read.quantity - 1);
        const ItemRange items{trial_read.read.start.value, last};
        for (const auto& range : bad) refuses = refuses || model::overlap(range, items);
        if (refuses)
            learning.on_refused(now, 2);
        else
            learning.on_taken(now);
    }

    model::Project project;
    Learning learning;
    plan::LinePlan plan;
    Instant now = at(1s);
};

struct Map {
    std::vector<int> registers;
    ItemRanges gaps;
    ItemRanges bad;
};

Map random_map() {
    Map map;
    int next = *rc::gen::inRange(0, 30);
    for (int i = *rc::gen::inRange(2, 30); i > 0; --i) {
        map.registers.push_back(next);
        const int gap = *rc::gen::element(0, 1, 2, 4);
        if (gap > 0 && i > 1) {
            map.gaps.push_back(
                {static_cast<std::uint16_t>(next + 1), static_cast<std::uint16_t>(next + gap)});
            if (*rc::gen::inRange(0, 4) == 0) map.bad.push_back(map.gaps.back());
        }
        next += gap + 1;
    }
    return map;
}

// One register of a bad gap is enough to make it bad.
RC_GTEST_PROP(Learning, GivesUpExactlyTheBadGapsInFewQuestions, ()) {
    const Map map = random_map();
    ItemRanges bad;
    for (const auto& gap : map.bad) bad.push_back({gap.last, gap.last});
    Trying trying(described(map.registers));
    const auto asked =
        trying.run(10min, [&](const auto& trial_read) { trying.take_answer(trial_read, bad); });
    RC_ASSERT(trying.refused() == map.bad);
    for (const auto& request : trying.plan.requests)
        for (const auto& gap : map.bad)
            RC_ASSERT(!model::overlap(
                gap, {request.start, static_cast<std::uint16_t>(request.start + request.quantity - 1)}));
    const std::size_t most = 1 + map.bad.size() * (2 * std::bit_width(map.gaps.size()) + Learning::kRefusals);
    RC_ASSERT(asked <= most);
}

// As many refusals as there may be without three in a row for the same gap.
TEST(Learning, RefusalsNowAndThenCostNothing) {
    std::mt19937 random(3);
    for (int round = 0; round < 40; ++round) {
        Trying trying(described({0, 3, 6, 9, 12, 20, 23, 27, 30}));
        const ItemRanges bad{{13, 19}};
        std::vector<ItemRange> last;
        trying.run(10min, [&](const auto& trial_read) {
            const auto first = trial_read.read.start.value;
            const ItemRange items{first, static_cast<std::uint16_t>(first + trial_read.read.quantity - 1)};
            const bool twice = std::count(last.begin(), last.end(), items) >= 2;
            const bool refuses = !twice && random() % 3 == 0;
            if (refuses) last.push_back(items);
            trying.take_answer(trial_read, bad, refuses);
        });
        EXPECT_EQ(trying.refused(), bad) << "round " << round;
        EXPECT_EQ(trying.plan.requests.size(), 2U);
    }
}

TEST(Learning, SilenceProvesNothingAndIsAskedForLessAndLess) {
    Trying trying(described({0, 3, 6, 9}));
    std::size_t silences = 0;
    trying.run(60min, [&](const auto& trial_read) {
        const bool chokes =
            trial_read.read.start.value <= 4 && trial_read.read.start.value + trial_read.read.quantity > 4;
        if (!chokes) return trying.take_answer(trial_read, {});
        ++silences;
        trying.learning.on_nothing(trying.now, true);
    });
    EXPECT_EQ(trying.refused(), ItemRanges{});
    EXPECT_EQ(trying.plan.requests.size(), 2U) << "the other two gaps are read";
    EXPECT_GE(silences, 6U);
    EXPECT_LE(silences, 25U);
}

TEST(Learning, ABusyDeviceIsAskedAgain) {
    Trying trying(described({0, 3, 6, 9}));
    int busy = 20;
    trying.run(60min, [&](const auto& trial_read) {
        if (--busy < 0) return trying.take_answer(trial_read, {});
        trying.learning.on_nothing(trying.now, false);
    });
    EXPECT_EQ(trying.plan.requests.size(), 1U);
}

// Each part is read, the whole is refused: no gap is to blame.
TEST(Learning, ADeviceThatTakesShortReadsOnlyKeepsItsGaps) {
    Trying trying(described({0, 3, 6, 9, 12, 15, 18, 21, 24}));
    trying.run(60min, [&](const auto& trial_read) {
        trying.take_answer(trial_read, {}, trial_read.read.quantity > 10);
    });
    EXPECT_EQ(trying.refused(), ItemRanges{});
    const auto learnt = trying.learning.learnt(trying.now)[0];
    EXPECT_GE(learnt.most_items[kHolding], 4);
    EXPECT_LE(learnt.most_items[kHolding], 10);
    EXPECT_LE(trying.plan.requests.size(), 4U);
}

TEST(Learning, WhatWasRefusedIsAskedForAgainAtLongIntervals) {
    Trying trying(described({0, 3}));
    ItemRanges bad{{1, 2}};
    std::vector<Instant> asked;
    const auto answer = [&](const auto& trial_read) {
        asked.push_back(trying.now);
        trying.take_answer(trial_read, bad);
    };
    trying.run(24h * 7, answer);
    ASSERT_GT(asked.size(), Learning::kRefusals + 5);
    EXPECT_LE(asked.size(), Learning::kRefusals + 13);
    EXPECT_GE(asked[Learning::kRefusals] - asked[Learning::kRefusals - 1], 1h);
    EXPECT_GE(asked.back() - asked[asked.size() - 2], 24h);
    bad.clear();
    trying.run(24h * 9, answer);
    EXPECT_EQ(trying.refused(), ItemRanges{});
    EXPECT_EQ(trying.plan.requests.size(), 1U) << "it has them now";
}

TEST(Learning, WhatIsKnownFromBeforeIsNotTriedAgain) {
    auto project = described({0, 3, 6});
    auto& learnt = project.lines[0].devices[0].learnt;
    learnt.confirmed[kHolding] = {{0, 3}};
    learnt.refused[kHolding] = {{.items = {4, 5}, .since = 10h, .checked = 1h}};
    Trying trying(project);
    std::vector<Instant> asked;
    trying.run(24h, [&](const auto& trial_read) {
        asked.push_back(trying.now);
        trying.take_answer(trial_read, {{4, 5}});
    });
    ASSERT_FALSE(asked.empty());
    EXPECT_GE(asked[0] - at(1s), 8h) << "nine hours after it had been refused for nine hours";
    EXPECT_EQ(trying.plan.requests.size(), 2U);
    EXPECT_GT(trying.learning.learnt(trying.now)[0].refused[kHolding][0].since, 10h);
}

}  // namespace learning_test
}  // namespace takt::poll
