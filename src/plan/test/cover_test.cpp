// Covers of spans against a search through all sets of requests.
#include "requests/cover.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

namespace takt::plan {
namespace cover_test {

struct Problem {
    std::vector<Span> spans;
    std::vector<Span> readable;
    RequestCost cost;
    std::uint32_t limit = 1;

    [[nodiscard]] CoverRules rules() const { return {cost, limit, readable}; }
};

constexpr std::uint32_t kItems = 48;
constexpr std::uint32_t kMostSpans = 7;

const std::vector<Span> kNothing;
const std::vector<Span> kEverything{{0, kItems}};
const std::vector<Span> kParts{{3, 17}, {20, 29}};

// From the whole range in small cases too.
std::uint32_t number(std::uint32_t least, std::uint32_t end) {
    return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(least, end));
}

bool holds(const Span& outer, const Span& inner) {
    return outer.start <= inner.start && inner.end <= outer.end;
}

bool by_start(const Span& a, const Span& b) {
    return std::pair(a.start, a.end) < std::pair(b.start, b.end);
}

// Few long spans among short ones, so that they lie inside one another and over the edges of others.
std::vector<Span> some_spans(std::uint32_t limit) {
    std::vector<Span> spans;
    const auto count = number(1, kMostSpans + 1);
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto longest = *rc::gen::element<std::uint32_t>(1, 2, 4, limit);
        const auto size = number(1, std::min(longest, limit) + 1);
        const auto start = number(0, kItems - size);
        spans.push_back({start, start + size});
    }
    std::sort(spans.begin(), spans.end(), by_start);
    return spans;
}

Problem problem() {
    Problem made;
    made.limit = number(1, kItems);
    made.spans = some_spans(made.limit);
    auto readable = made.spans;
    for (const Span& more : *rc::gen::element(kNothing, kEverything, kParts)) readable.push_back(more);
    std::sort(readable.begin(), readable.end(), by_start);
    made.readable = united(readable);
    made.cost.unit = *rc::gen::element<std::uint32_t>(1, 1, 3, 8);
    made.cost.base = number(0, 30);
    made.cost.step = number(0, 8);
    made.cost.floor = *rc::gen::element(0, 0, 10, 40, 60);
    return made;
}

using Total = std::pair<ExactTime, std::size_t>;

// The cheapest request for each set of spans that one request can hold.
std::map<unsigned, ExactTime> requests_of(const Problem& problem) {
    std::map<unsigned, ExactTime> cheapest;
    for (const Span& run : problem.readable)
        for (std::uint32_t start = run.start; start < run.end; ++start)
            for (std::uint32_t end = start + 1; end <= run.end && end - start <= problem.limit; ++end) {
                unsigned held = 0;
                for (std::size_t i = 0; i < problem.spans.size(); ++i)
                    if (holds({start, end}, problem.spans[i])) held |= 1U << i;
                const ExactTime cost = problem.cost(end - start);
                const auto [at, added] = cheapest.try_emplace(held, cost);
                if (!added) at->second = std::min(at->second, cost);
            }
    return cheapest;
}

Total least(const Problem& problem) {
    const auto requests = requests_of(problem);
    const unsigned all = (1U << problem.spans.size()) - 1;
    std::vector<Total> totals(all + 1, Total{ExactTime{1} << 100, 0});
    totals[0] = {0, 0};
    for (unsigned held = 0; held < all; ++held)
        for (const auto& [more, cost] : requests) {
            const unsigned both = held | more;
            if (both == held) continue;
            totals[both] = std::min(totals[both], {totals[held].first + cost, totals[held].second + 1});
        }
    return totals[all];
}

Total total_of(const Problem& problem, const std::vector<Window>& windows) {
    Total total{0, windows.size()};
    for (const Window& window : windows) total.first += problem.cost(window.items.size());
    return total;
}

void check(const Problem& problem, const std::vector<Window>& windows) {
    std::size_t next = 0;
    for (const Window& window : windows) {
        RC_ASSERT(window.first == next);
        next = window.last + 1;
        RC_ASSERT(window.items.size() <= problem.limit);
        RC_ASSERT(std::any_of(problem.readable.begin(), problem.readable.end(),
                              [&](const Span& run) { return holds(run, window.items); }));
        for (std::size_t i = window.first; i <= window.last; ++i)
            RC_ASSERT(holds(window.items, problem.spans[i]));
    }
    RC_ASSERT(next == problem.spans.size());
    for (std::size_t i = 1; i < windows.size(); ++i) {
        RC_ASSERT(windows[i - 1].items.start <= windows[i].items.start);
        RC_ASSERT(windows[i - 1].items.end <= windows[i].items.end);
    }
}

RC_GTEST_PROP(Cover, CostsWhatTheBestSetOfRequestsCosts, ()) {
    const Problem made = problem();
    const auto windows = cover(made.spans, made.rules());
    check(made, windows);
    RC_ASSERT(total_of(made, windows) == least(made));
}

// The same least cost on long rows, where every queue is in use, by the plain recurrence.
RC_GTEST_PROP(Cover, CostsWhatThePlainRecurrenceCosts, ()) {
    Problem made = problem();
    made.limit = number(8, 300);
    made.spans.clear();
    std::uint32_t start = 0;
    for (int i = 0; i < 120; ++i) {
        const auto step = number(0, 256);
        start += step % 16 == 0 ? step : step % 4;
        made.spans.push_back({start, start + 1 + step / 32});
    }
    std::sort(made.spans.begin(), made.spans.end(), by_start);
    auto readable = made.spans;
    if (*rc::gen::arbitrary<bool>()) readable.push_back({0, 4000});
    std::sort(readable.begin(), readable.end(), by_start);
    made.readable = united(readable);

    std::vector<Total> totals{{0, 0}};
    std::uint32_t reach = 0;
    for (std::size_t j = 0; j < made.spans.size(); ++j) {
        reach = std::max(reach, made.spans[j].end);
        Total best{ExactTime{1} << 100, 0};
        for (std::size_t i = 0; i <= j; ++i) {
            const Span items{made.spans[i].start, reach};
            if (items.size() > made.limit) continue;
            if (std::none_of(made.readable.begin(), made.readable.end(),
                             [&](const Span& run) { return holds(run, items); }))
                continue;
            best = std::min(best, {totals[i].first + made.cost(items.size()), totals[i].second + 1});
        }
        totals.push_back(best);
    }
    const auto windows = cover(made.spans, made.rules());
    check(made, windows);
    RC_ASSERT(total_of(made, windows) == totals.back());
}

struct Case {
    const char* what;
    Problem problem;
    std::vector<Span> expected;
};

const std::vector<Span> kAll{{0, 65536}};
constexpr RequestCost kTen{0, 10, 1, 1};  // a request costs as much as ten items

const Case kCases[] = {
    {"nothing", {{}, kAll, kTen, 125}, {}},
    {"a gap as dear as a request is bridged: fewer requests",
     {{{0, 1}, {11, 12}}, kAll, kTen, 125},
     {{0, 12}}},
    {"a gap dearer than a request", {{{0, 1}, {12, 13}}, kAll, kTen, 125}, {{0, 1}, {12, 13}}},
    {"a gap that must not be read", {{{0, 1}, {2, 3}}, {{0, 1}, {2, 3}}, kTen, 125}, {{0, 1}, {2, 3}}},
    {"one inside the other", {{{0, 20}, {5, 6}, {19, 22}}, kAll, kTen, 125}, {{0, 22}}},
    {"one inside the other, and both fit with the last only without the first",
     {{{0, 20}, {5, 6}, {19, 24}}, kAll, kTen, 20},
     {{0, 20}, {19, 24}}},
    {"the cut is where the gap is, not where the limit is",
     {{{0, 2}, {2, 4}, {9, 11}, {11, 13}}, kAll, kTen, 11},
     {{0, 4}, {9, 13}}},
    {"up to the floor items cost nothing",
     {{{0, 1}, {90, 91}, {190, 191}}, kAll, {100, 10, 1, 1}, 125},
     {{0, 91}, {190, 191}}},
    {"filled from the left where all cuts cost the same",
     {{{0, 2}, {2, 4}, {4, 6}, {6, 8}, {8, 10}}, kAll, kTen, 4},
     {{0, 4}, {4, 8}, {8, 10}}},
    {"filled from the left at the floor",
     {{{0, 1}, {30, 31}, {60, 61}, {90, 91}, {120, 121}, {150, 151}}, kAll, {300, 10, 1, 1}, 100},
     {{0, 91}, {120, 151}}},
    {"bits cost by the byte of the answer, wherever it begins",
     {{{3, 4}, {10, 11}, {11, 12}}, kAll, {0, 1, 1, 8}, 8},
     {{3, 11}, {11, 12}}},
    {"the last item there is", {{{65534, 65536}}, kAll, kTen, 2}, {{65534, 65536}}},
};

TEST(Cover, OfExamples) {
    for (const Case& tested : kCases) {
        std::vector<Span> items;
        for (const Window& window : cover(tested.problem.spans, tested.problem.rules()))
            items.push_back(window.items);
        EXPECT_EQ(items, tested.expected) << tested.what;
    }
}

TEST(Cover, UnitesSpansThatTouchOrOverlap) {
    const std::vector<Span> spans{{0, 2}, {1, 2}, {2, 3}, {5, 9}, {6, 7}, {10, 11}};
    EXPECT_EQ(united(spans), (std::vector<Span>{{0, 3}, {5, 9}, {10, 11}}));
    EXPECT_TRUE(united({}).empty());
}

}  // namespace cover_test

void PrintTo(const Span& span, std::ostream* out) {
    *out << '[' << span.start << ", " << span.end << ')';
}

}  // namespace takt::plan
