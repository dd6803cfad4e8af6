// Multi-rate cover. Periods are sorted and divided into blocks of consecutive periods. Within a block all
// spans that are due at an instant share one minimum-cost cover (cover.hpp). Blocks do not share requests. A
// dynamic programme over the sorted periods finds the best division:
//
//     best(j) = min over i of best(i) + worth(i..j-1)
//
// worth() sums the cover costs of the due sets of one hyperperiod (Calendar), plus a small price for each
// arithmetic progression of instants, so that ties prefer fewer requests.
#include "timing/timetable.hpp"

#include <algorithm>
#include <bit>
#include <limits>
#include <tuple>
#include <utility>

#include "takt/base/assert.hpp"

namespace takt::plan {
namespace {

constexpr std::size_t kBits = 64;

bool contains(const SpanSet& members, std::size_t span) {
    return (members[span / kBits] >> span % kBits & 1U) != 0;
}

void insert(SpanSet& members, std::size_t span) {
    members[span / kBits] |= std::uint64_t{1} << span % kBits;
}

void unite(SpanSet& members, const SpanSet& more) {
    for (std::size_t word = 0; word < members.size(); ++word) members[word] |= more[word];
}

// A window that is read at the instants of some due sets of a block.
struct Shape {
    std::uint64_t due_sets = 0;
    std::uint32_t periods = 0;  // union over the due sets
    int most_periods = 0;       // the most periods in one due set
    std::optional<Span> next;
};

std::vector<Duration> own_periods(std::span<const TimedSpan> spans) {
    std::vector<Duration> periods(spans.size());
    std::transform(spans.begin(), spans.end(), periods.begin(), [](const TimedSpan& s) { return s.period; });
    return periods;
}

}  // namespace

const Calendar* Calendars::of(std::span<const Duration> periods) {
    std::vector<Duration> key(periods.begin(), periods.end());
    auto at = calendars_.find(key);
    if (at == calendars_.end()) at = calendars_.emplace(std::move(key), Calendar::of(periods)).first;
    return at->second ? &*at->second : nullptr;
}

Neighbourhood::Neighbourhood(std::span<const TimedSpan> spans, const CoverRules& rules, Calendars& calendars)
    : spans_(spans), rules_(rules), calendars_(calendars) {
    alone_.periods = own_periods(spans);
    const auto all = groups(alone_.periods);
    for (const Group& group : all) {
        alone_.blocks.push_back(group.period);
        alone_.utilization += cost(group.members) / static_cast<double>(group.period.count());
    }
    alone_.progressions = all.size();
    progression_price_ = alone_.utilization / kProgressionsOfUtilization;
}

std::vector<Neighbourhood::Group> Neighbourhood::groups(const std::vector<Duration>& periods) const {
    std::vector<Duration> distinct = periods;
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    const SpanSet none((spans_.size() + kBits - 1) / kBits);
    std::vector<Group> groups;
    for (const Duration period : distinct) groups.push_back({period, none});
    for (std::size_t span = 0; span < periods.size(); ++span) {
        const auto at = std::lower_bound(distinct.begin(), distinct.end(), periods[span]);
        insert(groups[static_cast<std::size_t>(at - distinct.begin())].members, span);
    }
    return groups;
}

std::vector<Window> Neighbourhood::windows(const SpanSet& members) const {
    std::vector<Span> due;
    for (std::size_t span = 0; span < spans_.size(); ++span)
        if (contains(members, span)) due.push_back(spans_[span].items);
    return cover(due, rules_);
}

double Neighbourhood::cost(const SpanSet& members) {
    const auto [at, added] = costs_.try_emplace(members, 0);
    if (!added) return at->second;
    ExactTime total = 0;
    for (const Window& window : windows(members)) total += rules_.cost(window.items.size());
    return at->second = static_cast<double>(total);
}

SpanSet Neighbourhood::due(std::span<const Group> block, std::uint32_t periods) {
    SpanSet members(block.front().members.size());
    for (std::size_t i = 0; i < block.size(); ++i)
        if ((periods >> i & 1U) != 0) unite(members, block[i].members);
    return members;
}

const Calendar* Neighbourhood::calendar(std::span<const Group> block) const {
    std::vector<Duration> periods;
    for (const Group& group : block) periods.push_back(group.period);
    return calendars_.of(periods);
}

std::optional<Neighbourhood::Worth> Neighbourhood::worth(std::span<const Group> block) {
    const Calendar* when = calendar(block);
    if (!when) return std::nullopt;
    Worth worth{0, when->progression_count()};
    for (const auto& [periods, ticks] : when->due_sets())
        worth.utilization += cost(due(block, periods)) * static_cast<double>(ticks);
    worth.utilization /= static_cast<double>(when->hyperperiod().count());
    return worth;
}

double Neighbourhood::score(double utilization, std::size_t progressions) const {
    return utilization + progression_price_ * static_cast<double>(progressions);
}

bool Neighbourhood::better(const Timetable& a, const Timetable& b) const {
    constexpr double kNoise = 1e-12;  // the order of a sum changes its last bits
    return score(a.utilization, a.progressions) < score(b.utilization, b.progressions) * (1 - kNoise);
}

// The dynamic programme over the blocks (see above).
Timetable Neighbourhood::timetable(std::vector<Duration> periods) {
    const auto all = groups(periods);
    struct Best {
        Worth worth;
        std::size_t first = 0;  // of the last block
    };
    std::vector<Best> best(all.size() + 1);
    for (std::size_t end = 1; end <= all.size(); ++end) {
        double least = std::numeric_limits<double>::infinity();
        const std::size_t longest = std::min(end, Calendar::kMostPeriods);
        for (std::size_t first = end; first-- > end - longest;) {
            const auto block = worth(std::span(all).subspan(first, end - first));
            if (!block) continue;
            const Worth sum{best[first].worth.utilization + block->utilization,
                            best[first].worth.progressions + block->progressions};
            if (score(sum.utilization, sum.progressions) >= least) continue;
            least = score(sum.utilization, sum.progressions);
            best[end] = {sum, first};
        }
    }
    Timetable made{std::move(periods), {}, best.back().worth.utilization, best.back().worth.progressions};
    for (std::size_t end = all.size(); end > 0; end = best[end].first)
        made.blocks.insert(made.blocks.begin(), all[end - 1].period);
    return made;
}

std::vector<Span> Neighbourhood::read_with(const Timetable& timetable, Duration period) const {
    std::vector<Span> read;
    for (const Group& group : groups(timetable.periods)) {
        if (group.period != period) continue;
        for (const Window& window : windows(group.members)) read.push_back(window.items);
    }
    return read;
}

std::vector<TimedWindow> Neighbourhood::requests(const Timetable& timetable) const {
    const auto all = groups(timetable.periods);
    std::vector<TimedWindow> requests;
    std::size_t first = 0;
    for (const Duration last : timetable.blocks) {
        std::size_t end = first;
        while (end < all.size() && all[end].period <= last) ++end;
        add_requests(std::span(all).subspan(first, end - first), requests);
        first = end;
    }
    std::sort(requests.begin(), requests.end(), [](const TimedWindow& a, const TimedWindow& b) {
        return std::tie(a.items.start, a.items.end, a.progression.phase, a.progression.period) <
               std::tie(b.items.start, b.items.end, b.progression.phase, b.progression.period);
    });
    return requests;
}

void Neighbourhood::add_requests(std::span<const Group> block, std::vector<TimedWindow>& requests) const {
    const Calendar* when = calendar(block);
    TAKT_ASSERT(when);
    std::map<std::pair<std::uint32_t, std::uint32_t>, Shape> shapes;  // by start and end
    const auto due_sets = when->due_sets();
    for (std::size_t set = 0; set < due_sets.size(); ++set) {
        const auto found = windows(due(block, due_sets[set].periods));
        for (std::size_t i = 0; i < found.size(); ++i) {
            Shape& shape = shapes[{found[i].items.start, found[i].items.end}];
            shape.due_sets |= std::uint64_t{1} << set;
            shape.periods |= due_sets[set].periods;
            const int periods = std::popcount(due_sets[set].periods);
            if (periods <= shape.most_periods) continue;
            shape.most_periods = periods;
            shape.next.reset();
            if (i + 1 < found.size()) shape.next = found[i + 1].items;
        }
    }
    const SpanSet all = due(block, ~std::uint32_t{0});
    for (const auto& [items, shape] : shapes) {
        const SpanSet wanted = due(block, shape.periods);
        TimedWindow request{{items.first, items.second}, {}, {}, shape.next};
        const auto begin =
            std::lower_bound(spans_.begin(), spans_.end(), items.first,
                             [](const TimedSpan& s, auto start) { return s.items.start < start; });
        for (auto at = begin; at != spans_.end() && at->items.start < items.second; ++at) {
            const auto span = static_cast<std::size_t>(at - spans_.begin());
            if (at->items.end <= items.second && contains(at->fixed ? wanted : all, span))
                request.spans.push_back(span);
        }
        for (const Progression& progression : when->progressions(shape.due_sets)) {
            request.progression = progression;
            requests.push_back(request);
        }
    }
}

}  // namespace takt::plan
