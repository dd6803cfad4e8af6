// Plans of strategy optimal for variables with several periods, seen from outside.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "builder.hpp"

namespace takt::plan {
namespace optimal_rounds_test {

using namespace test;
using PeriodSet = std::vector<Duration>;

std::vector<Item> some_items(const PeriodSet& periods) {
    std::vector<Item> items;
    int next = 0;
    const auto count = *rc::gen::inRange(1, 24);
    for (int i = 0; i < count; ++i) {
        Item item = *rc::gen::element(int16(0), real(0), test::item(DataType::float64, 0));
        next += *rc::gen::weightedElement<int>({{6, 0}, {2, 1}, {1, 7}, {1, 60}});
        item.register_number = static_cast<std::uint16_t>(next);
        next += item.registers;
        items.push_back(item.read(3).every(*rc::gen::elementOf(periods)));
    }
    return items;
}

PeriodSet some_periods() {
    return *rc::gen::element(PeriodSet{100ms, 1000ms}, PeriodSet{100ms, 200ms, 500ms, 1000ms},
                             PeriodSet{250ms, 1s, 5s, 60s}, PeriodSet{300ms, 500ms},
                             PeriodSet{100ms, 150ms, 1000ms}, PeriodSet{97ms, 101ms, 103ms, 107ms},
                             PeriodSet{0ms, 100ms, 300ms}, PeriodSet{100ms, 1h});
}

model::Project some_project(const PeriodSet& periods) {
    Settings settings{.strategy = model::Strategy::optimal};
    auto made = project(settings, some_items(periods));
    made.lines[0].format.baud = *rc::gen::element<std::uint32_t>(1200, 9600, 115200);
    auto& device = made.lines[0].devices[0];
    device.gaps = *rc::gen::element(model::Gaps::never, model::Gaps::always);
    device.turnaround = *rc::gen::element(0ms, 5ms, 50ms);
    if (*rc::gen::arbitrary<bool>()) {
        device.registers_per_request = *rc::gen::element<std::uint16_t>(2, 5, 16);
        device.registers_per_request_set = true;
    }
    return made;
}

bool whole_in(const Request& request, const model::Variable& v) {
    return request.start <= v.start() && v.start() + v.items() <= request.start + request.quantity;
}

bool due(const Request& request, Duration t) {
    return t >= request.phase && (t - request.phase) % *request.period == 0ms;
}

// Latest of the instants at which one of the requests is due, before `t`; all have begun by then.
void check_gaps(const std::vector<const Request*>& requests, Duration period) {
    std::set<Duration> instants;
    Duration longest{};
    for (const auto* request : requests) longest = std::max(longest, *request->period);
    // Any window of one hyperperiod would do; those here are short enough to look at one after the other.
    std::int64_t repeats = 1;
    for (const auto* request : requests) repeats = std::lcm(repeats, request->period->count());
    const Duration end = longest + Duration(repeats);
    for (const auto* request : requests)
        for (Duration t = request->phase; t <= end; t += *request->period) instants.insert(t);
    Duration last{};
    for (const Duration t : instants) {
        RC_ASSERT(t - last <= period);
        last = t;
    }
    RC_ASSERT(end - last <= period);
}

RC_GTEST_PROP(OptimalRounds, ReadEachVariableInTime, ()) {
    const auto made = some_project(some_periods());
    const auto plan = make_plan(made).lines[0];
    const auto& variables = made.lines[0].devices[0].variables;
    for (std::size_t i = 0; i < variables.size(); ++i) {
        const auto limit = made.lines[0].devices[0].registers_per_request;
        const bool cut = made.lines[0].devices[0].registers_per_request_set && variables[i].items() > limit;
        std::vector<const Request*> readers;
        for (const Request& request : plan.requests) {
            const auto& named = request.variables;
            if (std::find(named.begin(), named.end(), i) == named.end()) continue;
            RC_ASSERT(cut || whole_in(request, variables[i]));
            readers.push_back(&request);
        }
        RC_ASSERT(!readers.empty());
        if (variables[i].period == 0ms) {
            for (const auto* request : readers) RC_ASSERT(*request->period == 0ms);
        } else if (!cut) {
            check_gaps(readers, variables[i].period);
        }
    }
}

double utilization_of(const LinePlan& plan) {
    double sum = 0;
    for (const Request& request : plan.requests)
        if (request.period && *request.period > 0ms)
            sum +=
                static_cast<double>(request.bus_time.count()) / static_cast<double>(request.period->count());
    return sum;
}

RC_GTEST_PROP(OptimalRounds, AreNoBusierThanEachPeriodAlone, ()) {
    const auto periods = some_periods();
    const auto made = some_project(periods);
    const auto plan = make_plan(made).lines[0];
    double alone = 0;
    for (const Duration period : periods) {
        auto one = made;
        std::erase_if(one.lines[0].devices[0].variables,
                      [period](const model::Variable& v) { return v.period != period; });
        alone += utilization_of(make_plan(one).lines[0]);
    }
    RC_ASSERT(utilization_of(plan) <= alone * (1 + 1e-6));
    RC_ASSERT(std::abs(plan.utilization - utilization_of(plan)) < 1e-5);
}

auto shape(const model::Device& device, const Request& request) {
    std::vector<std::tuple<std::uint16_t, Duration>> members;
    for (const auto v : request.variables)
        members.emplace_back(device.variables[v].start(), device.variables[v].period);
    return std::tuple(request.start, request.quantity, request.period, request.phase, request.stream,
                      request.deadline, request.why.code, members);
}

RC_GTEST_PROP(OptimalRounds, DoNotDependOnTheOrderOfTheFile, (unsigned seed)) {
    const auto made = some_project(some_periods());
    auto shuffled = made;
    std::mt19937 random(seed);
    auto& variables = shuffled.lines[0].devices[0].variables;
    std::shuffle(variables.begin(), variables.end(), random);
    const auto plan = make_plan(made).lines[0];
    const auto again = make_plan(shuffled).lines[0];
    RC_ASSERT(plan.requests.size() == again.requests.size());
    for (std::size_t i = 0; i < plan.requests.size(); ++i)
        RC_ASSERT(shape(made.lines[0].devices[0], plan.requests[i]) ==
                  shape(shuffled.lines[0].devices[0], again.requests[i]));
}

RC_GTEST_PROP(OptimalRounds, ShareADeadlineWhereTheyShareVariables, ()) {
    const auto made = some_project(some_periods());
    const auto plan = make_plan(made).lines[0];
    const auto& variables = made.lines[0].devices[0].variables;
    for (const Request& a : plan.requests) {
        if (*a.period == 0ms) {
            RC_ASSERT(!a.deadline);
            continue;
        }
        for (const auto v : a.variables) RC_ASSERT(*a.deadline <= variables[v].period);
        for (const Request& b : plan.requests) {
            const bool share = std::any_of(a.variables.begin(), a.variables.end(), [&b](std::size_t v) {
                return std::find(b.variables.begin(), b.variables.end(), v) != b.variables.end();
            });
            if (share && *b.period > 0ms) RC_ASSERT(a.stream == b.stream && a.deadline == b.deadline);
        }
    }
}

// Shapes of one stream are never due at once, unless their variables overlap.
TEST(OptimalRounds, TakeTurns) {
    const Settings settings{.strategy = model::Strategy::optimal};
    const auto plan =
        plan_of(settings, {int16(0).read(3).every(100ms), int16(1).read(3).every(1000ms).named("slow")});
    ASSERT_EQ(plan.requests.size(), 6U);
    for (Duration t = 0ms; t < 2s; t += 100ms) {
        std::vector<const Request*> now;
        for (const auto& request : plan.requests)
            if (due(request, t)) now.push_back(&request);
        ASSERT_EQ(now.size(), 1U) << t.count();
        EXPECT_EQ(now[0]->quantity, t % 1s == 0ms ? 2 : 1);
        EXPECT_EQ(now[0]->stream, 0U);
        EXPECT_EQ(now[0]->deadline, 100ms);
        EXPECT_EQ(now[0]->why.code, t % 1s == 0ms ? "plan.last" : "plan.other_period");
    }
    EXPECT_EQ(plan.cycle, plan.requests.back().bus_time) << "the longest round is that of both";
}

TEST(OptimalRounds, SpreadWhatIsSlow) {
    const Settings settings{.strategy = model::Strategy::optimal};
    std::vector<Item> items{int16(0).read(3).every(100ms)};
    for (int i = 1; i <= 10; ++i) items.push_back(int16(1000 * i).read(3).every(1000ms));
    const auto plan = plan_of(settings, items);
    ASSERT_EQ(plan.requests.size(), 11U);
    EXPECT_EQ(plan.longest_round.size(), 2U) << "one slow request in each round";
    std::set<Duration> phases;
    for (const auto& request : plan.requests) phases.insert(request.phase);
    EXPECT_EQ(phases.size(), 10U);
}

TEST(OptimalRounds, KeepPhaseZeroWithOnePeriod) {
    const Settings settings{.strategy = model::Strategy::optimal};
    std::vector<Item> items;
    for (int i = 0; i < 5; ++i) items.push_back(int16(1000 * i).read(3).every(500ms));
    for (const auto& request : plan_of(settings, items).requests) EXPECT_EQ(request.phase, 0ms);
}

}  // namespace optimal_rounds_test
}  // namespace takt::plan
