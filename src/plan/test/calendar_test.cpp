// Calendars against counting, tick by tick.
#include "timing/calendar.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

namespace takt::plan {
namespace calendar_test {

using namespace std::chrono_literals;

// As many of a random set as keep to the limits.
std::vector<Duration> some_periods() {
    const auto few = rc::gen::container<std::set<std::int64_t>>(rc::gen::elementOf(
        std::vector<std::int64_t>{20, 30, 50, 60, 70, 100, 150, 200, 250, 300, 500, 1000, 2000, 60000}));
    const auto chosen = *rc::gen::suchThat(few, [](const auto& set) { return !set.empty(); });
    std::vector<Duration> periods;
    for (const auto ms : chosen) periods.push_back(std::chrono::milliseconds(ms));
    while (!Calendar::of(periods)) periods.pop_back();
    return periods;
}

std::int64_t hyperperiod(const std::vector<Duration>& periods) {
    return std::accumulate(periods.begin(), periods.end(), std::int64_t{1},
                           [](std::int64_t all, Duration one) { return std::lcm(all, one.count()); });
}

// The instants of each due set, by counting through a hyperperiod of at most kMostTicks.
std::map<std::uint32_t, std::set<std::int64_t>> instants(const std::vector<Duration>& periods) {
    std::int64_t tick = 0;
    for (const auto period : periods) tick = std::gcd(tick, period.count());
    std::map<std::uint32_t, std::set<std::int64_t>> all;
    for (std::int64_t t = 0; t < hyperperiod(periods); t += tick) {
        std::uint32_t due = 0;
        for (std::size_t i = 0; i < periods.size(); ++i)
            if (t % periods[i].count() == 0) due |= 1U << i;
        if (due != 0) all[due].insert(t);
    }
    return all;
}

RC_GTEST_PROP(Calendars, HoldWhatCountingFinds, ()) {
    const auto periods = some_periods();
    const auto calendar = Calendar::of(periods);
    const auto expected = instants(periods);
    RC_ASSERT(calendar->hyperperiod().count() == hyperperiod(periods));
    RC_ASSERT(calendar->due_sets().size() == expected.size());
    for (const auto& [due, ticks] : calendar->due_sets()) RC_ASSERT(expected.at(due).size() == ticks);
    RC_ASSERT(calendar->progression_count() <= Calendar::kMostProgressions);
}

RC_GTEST_PROP(Calendars, GiveEachInstantToOneTurn, (std::uint64_t chosen)) {
    const auto periods = some_periods();
    const auto calendar = Calendar::of(periods);
    const auto all = instants(periods);
    std::set<std::int64_t> expected;
    for (std::size_t i = 0; i < calendar->due_sets().size(); ++i)
        if ((chosen >> i & 1U) != 0) expected.merge(std::set(all.at(calendar->due_sets()[i].periods)));
    std::multiset<std::int64_t> found;
    for (const Progression& progression : calendar->progressions(chosen)) {
        RC_ASSERT(progression.phase >= 0ns && progression.phase < progression.period);
        RC_ASSERT(calendar->hyperperiod() % progression.period == 0ns);
        for (Duration t = progression.phase; t < calendar->hyperperiod(); t += progression.period)
            found.insert(t.count());
    }
    RC_ASSERT(std::vector(found.begin(), found.end()) == std::vector(expected.begin(), expected.end()));
}

TEST(Calendars, TakeTurnsAsAReaderWould) {
    const std::vector<Duration> periods{100ms, 1000ms};
    const auto calendar = Calendar::of(periods);
    ASSERT_TRUE(calendar);
    ASSERT_EQ(calendar->due_sets().size(), 2U) << "the fast one alone, both";
    const std::vector<Progression> alone{
        {200ms, 100ms}, {1000ms, 200ms}, {1000ms, 400ms}, {1000ms, 600ms}, {1000ms, 800ms}};
    EXPECT_EQ(calendar->progressions(1), alone);
    EXPECT_EQ(calendar->progressions(2), (std::vector<Progression>{{1000ms, 0ms}}));
    EXPECT_EQ(calendar->progressions(3), (std::vector<Progression>{{100ms, 0ms}}));
    EXPECT_EQ(calendar->progression_count(), 6U);
}

struct Limit {
    std::vector<Duration> periods;
    bool within;
};

class CalendarLimits : public testing::TestWithParam<Limit> {};

TEST_P(CalendarLimits, AreKept) {
    EXPECT_EQ(Calendar::of(GetParam().periods).has_value(), GetParam().within);
}

std::vector<Duration> doubling(std::size_t count) {
    std::vector<Duration> periods{1ms};
    while (periods.size() < count) periods.push_back(2 * periods.back());
    return periods;
}

INSTANTIATE_TEST_SUITE_P(Sets, CalendarLimits,
                         testing::Values(Limit{{24h}, true}, Limit{{300ms, 500ms}, true},
                                         Limit{{100ms, 150ms, 1000ms}, true},
                                         Limit{{250ms, 1s, 5s, 60s}, true},
                                         Limit{{100ms, 200ms, 500ms, 1s}, true}, Limit{{1ms, 4096ms}, true},
                                         Limit{{1ms, 4099ms}, false}, Limit{doubling(13), true},
                                         Limit{doubling(14), false}, Limit{{100ms, 1h}, false},
                                         Limit{{1ns, 24h}, false}, Limit{{97ms, 101ms, 103ms, 107ms}, false},
                                         Limit{{13ms, 17ms}, true}, Limit{{61ms, 67ms}, false}));

}  // namespace calendar_test
}  // namespace takt::plan
