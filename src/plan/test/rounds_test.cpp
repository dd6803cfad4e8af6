// Rounds against the due sets of every instant, each covered by a search through all ways to divide it.
#include "requests/rounds.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>

namespace takt::plan {
namespace rounds_test {

using namespace std::chrono_literals;

constexpr std::uint32_t kItems = 60;
constexpr double kNoise = 1e-9;

struct Problem {
    std::vector<TimedSpan> spans;
    std::vector<Span> readable;
    RequestCost cost;
    std::uint32_t limit = 1;

    [[nodiscard]] CoverRules rules() const { return {cost, limit, readable}; }
};

bool before(const TimedSpan& a, const TimedSpan& b) {
    return std::tuple(a.items.start, a.items.end, a.period) <
           std::tuple(b.items.start, b.items.end, b.period);
}

// The items that may be read: those asked for, or all.
void complete(Problem& problem, bool gaps) {
    std::sort(problem.spans.begin(), problem.spans.end(), before);
    std::vector<Span> occupied;
    for (const auto& span : problem.spans) occupied.push_back(span.items);
    problem.readable = gaps ? std::vector<Span>{{0, 65536}} : united(occupied);
}

using PeriodSet = std::vector<Duration>;

PeriodSet some_period_set() {
    return *rc::gen::element(PeriodSet{100ms, 1000ms}, PeriodSet{100ms, 200ms, 500ms, 1000ms},
                             PeriodSet{250ms, 1000ms, 5000ms, 60s}, PeriodSet{300ms, 500ms},
                             PeriodSet{100ms, 150ms, 1000ms}, PeriodSet{100ms, 250ms},
                             PeriodSet{200ms, 300ms, 400ms}, PeriodSet{500ms, 700ms});
}

Problem problem(const PeriodSet& periods) {
    Problem made;
    made.limit = *rc::gen::inRange<std::uint32_t>(4, 40);
    const auto count = *rc::gen::inRange<std::size_t>(1, 9);
    for (std::size_t i = 0; i < count; ++i) {
        const auto size = *rc::gen::element<std::uint32_t>(1, 1, 2, 4);
        const auto start = *rc::gen::inRange<std::uint32_t>(0, kItems - size);
        made.spans.push_back({{start, start + size}, *rc::gen::elementOf(periods)});
    }
    made.cost.unit = *rc::gen::element<std::uint32_t>(1, 1, 8);
    made.cost.base = *rc::gen::inRange(5, 30) * 1'000'000;
    made.cost.step = *rc::gen::inRange(0, 8) * 1'000'000;
    made.cost.floor = *rc::gen::element(0, 0, 10, 40) * 1'000'000;
    complete(made, *rc::gen::arbitrary<bool>());
    return made;
}

bool holds(const Span& outer, const Span& inner) {
    return outer.start <= inner.start && inner.end <= outer.end;
}

// ---- the reference

// Every set of spans is divided into the one request that holds its first span and any others, and the rest.
class Reference {
public:
    explicit Reference(const Problem& problem) : problem_(problem) {}

    double cost(unsigned due) {
        if (due == 0) return 0;
        const auto [at, added] = costs_.try_emplace(due, std::numeric_limits<double>::infinity());
        if (!added) return at->second;
        double least = std::numeric_limits<double>::infinity();
        const unsigned first = due & (~due + 1);
        const unsigned others = due ^ first;
        for (unsigned more = others;; more = (more - 1) & others) {
            const auto request = request_cost(first | more);
            if (request) least = std::min(least, *request + cost(others ^ more));
            if (more == 0) break;
        }
        return costs_[due] = least;
    }

    // Everything that is due at an instant, covered anew, over all instants of a hyperperiod.
    double aligned() {
        std::int64_t hyperperiod = 1;
        std::int64_t tick = 0;
        for (const auto& span : problem_.spans) {
            hyperperiod = std::lcm(hyperperiod, span.period.count());
            tick = std::gcd(tick, span.period.count());
        }
        double total = 0;
        for (std::int64_t t = 0; t < hyperperiod; t += tick)
            total += cost(where([t](const TimedSpan& span) { return t % span.period.count() == 0; }));
        return total / static_cast<double>(hyperperiod);
    }

    double alone() {
        std::set<Duration> periods;
        for (const auto& span : problem_.spans) periods.insert(span.period);
        double total = 0;
        for (const Duration period : periods)
            total += cost(where([period](const TimedSpan& span) { return span.period == period; })) /
                     static_cast<double>(period.count());
        return total;
    }

private:
    template <typename Condition>
    unsigned where(Condition condition) {
        unsigned set = 0;
        for (std::size_t i = 0; i < problem_.spans.size(); ++i)
            if (condition(problem_.spans[i])) set |= 1U << i;
        return set;
    }

    std::optional<double> request_cost(unsigned held) {
        Span items{65536, 0};
        for (std::size_t i = 0; i < problem_.spans.size(); ++i) {
            if ((held >> i & 1U) == 0) continue;
            items.start = std::min(items.start, problem_.spans[i].items.start);
            items.end = std::max(items.end, problem_.spans[i].items.end);
        }
        const bool may_read = std::any_of(problem_.readable.begin(), problem_.readable.end(),
                                          [&items](const Span& run) { return holds(run, items); });
        if (!may_read || items.size() > problem_.limit) return std::nullopt;
        return static_cast<double>(problem_.cost(items.size()));
    }

    const Problem& problem_;
    std::map<unsigned, double> costs_;
};

double utilization(const Problem& problem, const std::vector<TimedWindow>& requests) {
    double total = 0;
    for (const auto& request : requests)
        total += static_cast<double>(problem.cost(request.items.size())) /
                 static_cast<double>(request.progression.period.count());
    return total;
}

// ---- what must hold

RC_GTEST_PROP(Rounds, AreNoDearerThanEachPeriodAlone, ()) {
    const auto made = problem(some_period_set());
    const double found = utilization(made, rounds(made.spans, made.rules()));
    RC_ASSERT(found <= Reference(made).alone() * (1 + kNoise));
}

RC_GTEST_PROP(Rounds, AreNearTheBestForEachInstant, ()) {
    const auto made = problem(some_period_set());
    const double found = utilization(made, rounds(made.spans, made.rules()));
    RC_ASSERT(found <= Reference(made).aligned() * 1.01);
}

// Instants of each span from the requests that name it.
void check_instants(const Problem& problem, const std::vector<TimedWindow>& requests) {
    for (std::size_t i = 0; i < problem.spans.size(); ++i) {
        std::int64_t hyperperiod = 1;
        std::vector<Progression> progressions;
        for (const auto& request : requests) {
            if (std::find(request.spans.begin(), request.spans.end(), i) == request.spans.end()) continue;
            RC_ASSERT(holds(request.items, problem.spans[i].items));
            progressions.push_back(request.progression);
            hyperperiod = std::lcm(hyperperiod, request.progression.period.count());
        }
        RC_ASSERT(!progressions.empty());
        std::set<std::int64_t> instants;
        for (const Progression& progression : progressions)
            for (std::int64_t t = progression.phase.count(); t < 2 * hyperperiod;
                 t += progression.period.count())
                instants.insert(t);
        RC_ASSERT(*instants.begin() == 0);
        std::int64_t last = 0;
        for (const std::int64_t t : instants) {
            RC_ASSERT(t - last <= problem.spans[i].period.count());
            last = t;
        }
        RC_ASSERT(2 * hyperperiod - last <= problem.spans[i].period.count());
    }
}

RC_GTEST_PROP(Rounds, ReadEachSpanInTime, ()) {
    const auto made = problem(some_period_set());
    const auto requests = rounds(made.spans, made.rules());
    check_instants(made, requests);
    for (const auto& request : requests) {
        RC_ASSERT(request.progression.phase >= 0ns && request.progression.phase < request.progression.period);
        RC_ASSERT(request.items.size() <= made.limit);
        RC_ASSERT(std::any_of(made.readable.begin(), made.readable.end(),
                              [&](const Span& run) { return holds(run, request.items); }));
        RC_ASSERT(!request.spans.empty());
    }
}

// Periods of any kind, most of them beyond the limits of a calendar.
RC_GTEST_PROP(Rounds, ReadInTimeWithAnyPeriods, ()) {
    PeriodSet periods;
    for (int i = 0; i < 4; ++i) periods.push_back(std::chrono::milliseconds(*rc::gen::inRange(2, 60)));
    const auto made = problem(periods);
    const auto requests = rounds(made.spans, made.rules());
    check_instants(made, requests);
    RC_ASSERT(utilization(made, requests) <= Reference(made).alone() * (1 + kNoise));
}

// Registers at 9600 bit/s 8N1, 5 ms of turnaround: 28.7 ms and 2.1 ms a register more, in nanoseconds.
Problem serial(std::vector<TimedSpan> spans, bool gaps = true) {
    Problem made;
    made.spans = std::move(spans);
    made.limit = 125;
    made.cost = {.floor = 0, .base = 26'000'000, .step = 2'100'000, .unit = 1};
    complete(made, gaps);
    return made;
}

TEST(Rounds, ReadASlowSpanInAGapOfAFastRequestForNothing) {
    const auto made = serial({{{0, 2}, 300ms}, {{2, 3}, 500ms}, {{3, 5}, 300ms}});
    const auto requests = rounds(made.spans, made.rules());
    ASSERT_EQ(requests.size(), 1U);
    EXPECT_EQ(requests[0].items, (Span{0, 5}));
    EXPECT_EQ(requests[0].progression, (Progression{300ms, 0ms}));
    EXPECT_EQ(requests[0].spans, (std::vector<std::size_t>{0, 1, 2}));
}

TEST(Rounds, KeepThePeriodOfWhatIsFixed) {
    auto made = serial({{{0, 2}, 300ms}, {{2, 3}, 500ms, true}, {{3, 5}, 300ms}});
    const auto requests = rounds(made.spans, made.rules());
    check_instants(made, requests);
    for (const auto& request : requests) {
        const bool named = std::count(request.spans.begin(), request.spans.end(), 1U) > 0;
        EXPECT_EQ(named, request.progression.phase % 500ms == 0ns)
            << "a bystander of the others is not named";
    }
}

TEST(Rounds, ReadNeighboursOfHarmonicPeriodsTogether) {
    const auto made = serial({{{0, 2}, 100ms}, {{2, 22}, 1000ms}});
    const auto requests = rounds(made.spans, made.rules());
    const double fast = static_cast<double>(made.cost(2));
    const double both = static_cast<double>(made.cost(22));
    EXPECT_NEAR(utilization(made, requests), (9 * fast + both) / 1e9, 1e-9);
    EXPECT_EQ(requests.size(), 6U) << "both, and the fast one in the five turns of nine tenths";
}

// Far apart they have nothing in common, an hour and a tenth of a second nothing worth a turn.
TEST(Rounds, StayApartWhereLittleIsSaved) {
    const auto far = serial({{{0, 2}, 100ms}, {{200, 202}, 1000ms}});
    EXPECT_EQ(rounds(far.spans, far.rules()).size(), 2U);
    const auto rare = serial({{{0, 2}, 100ms}, {{2, 22}, 1h}});
    EXPECT_EQ(rounds(rare.spans, rare.rules()).size(), 2U);
}

TEST(Rounds, OfCoprimePeriodsAreFew) {
    std::vector<TimedSpan> spans;
    const Duration periods[] = {97ms, 101ms, 103ms, 107ms};
    for (std::uint32_t i = 0; i < 400; ++i) spans.push_back({{2 * i, 2 * i + 2}, periods[i % 4]});
    const auto made = serial(spans);
    const auto requests = rounds(made.spans, made.rules());
    check_instants(made, requests);
    EXPECT_LE(requests.size(), 7U) << "800 registers, at most 125 in a request, all as often as the fastest";
}

TEST(Rounds, OfManyPeriodsAreFound) {
    std::vector<TimedSpan> spans;
    for (std::uint32_t i = 0; i < 300; ++i)
        spans.push_back({{i, i + 1}, std::chrono::milliseconds(50 + i * 7919 % 1000)});
    const auto made = serial(spans);
    const auto requests = rounds(made.spans, made.rules());
    check_instants(made, requests);
    std::map<Duration, std::vector<Span>> apart;
    for (const auto& span : made.spans) apart[span.period].push_back(span.items);
    double alone = 0;
    for (const auto& [period, items] : apart)
        for (const Window& window : cover(items, made.rules()))
            alone +=
                static_cast<double>(made.cost(window.items.size())) / static_cast<double>(period.count());
    EXPECT_LE(utilization(made, requests), alone);
}

TEST(Rounds, OfOnePeriodAreItsCover) {
    std::mt19937 random(1);
    std::vector<TimedSpan> spans;
    for (std::uint32_t i = 0; i < 500; ++i) {
        const auto start = static_cast<std::uint32_t>(random() % 9000);
        spans.push_back({{start, start + 1 + static_cast<std::uint32_t>(random() % 4)}, 100ms});
    }
    for (const bool gaps : {false, true}) {
        const auto made = serial(spans, gaps);
        std::vector<Span> items;
        for (const auto& span : made.spans) items.push_back(span.items);
        std::vector<Span> expected;
        for (const Window& window : cover(items, made.rules())) expected.push_back(window.items);
        std::vector<Span> found;
        for (const auto& request : rounds(made.spans, made.rules())) found.push_back(request.items);
        EXPECT_EQ(found, expected);
    }
}

}  // namespace rounds_test
}  // namespace takt::plan
