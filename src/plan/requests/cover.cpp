// Minimum-cost cover of spans by requests: a dynamic programme with monotone queues, O(n * unit).
//
// Some optimal cover takes the spans in the order of their starts, spans i..j in one request, with ascending
// ends. Proof: take an optimum in which no request lies inside another. Assign each span to the last request
// that contains it. Cut each request to its assigned spans. With reach(j) = the greatest end of spans 0..j:
//
//     best(j) = min over i of best(i - 1) + cost(reach(j) - start(i))
//
// Lower bound of i: the item limit and the readable run. The bound never falls as j grows.
// Flat part: while the cost is at its floor, the least such i is optimal because best() never falls.
// Sloped part: the cost is affine in ceil((reach - start) / unit). For starts with equal remainder modulo
// `unit` this splits into a term of j and a term of i. So one monotone queue per remainder keeps the
// candidates that can still win.
#include "requests/cover.hpp"

#include <algorithm>
#include <compare>

#include "takt/base/assert.hpp"

namespace takt::plan {
namespace {

struct Total {
    ExactTime cost = 0;
    std::uint32_t requests = 0;
    friend auto operator<=>(const Total&, const Total&) = default;
};

struct Choice {
    Total total;
    std::size_t first = 0;

    [[nodiscard]] bool better_than(const Choice& other) const {
        return total != other.total ? total < other.total : first > other.first;
    }
};

// Monotone queue: possible first spans of a request, all starts with one remainder, totals ascending.
class Candidates {
public:
    void push(const Choice& candidate) {
        while (head_ < choices_.size() && choices_.back().total >= candidate.total) choices_.pop_back();
        choices_.push_back(candidate);
    }
    void drop_before(std::size_t first) {
        while (head_ < choices_.size() && choices_[head_].first < first) ++head_;
    }
    [[nodiscard]] bool empty() const { return head_ == choices_.size(); }
    [[nodiscard]] const Choice& best() const { return choices_[head_]; }

private:
    std::vector<Choice> choices_;
    std::size_t head_ = 0;
};

class Cover {
public:
    Cover(std::span<const Span> spans, const CoverRules& rules)
        : spans_(spans),
          rules_(rules),
          at_floor_(rules.cost.items_at_floor()),
          totals_(spans.size() + 1),
          firsts_(spans.size()),
          reach_(spans.size()),
          candidates_(rules.cost.unit) {}

    std::vector<Window> windows();

private:
    void move_lower_bound(std::size_t last);
    void admit_candidates(std::size_t last);
    [[nodiscard]] Choice best_choice(std::size_t last);

    std::span<const Span> spans_;
    const CoverRules& rules_;
    std::uint32_t at_floor_;
    std::vector<Total> totals_;          // totals_[i]: best cover of the spans before i
    std::vector<std::uint32_t> firsts_;  // first span of the request that ends with span i
    std::vector<std::uint32_t> reach_;
    std::vector<Candidates> candidates_;
    std::size_t run_ = 0;         // readable run of the current span
    std::size_t least_ = 0;       // lower bound of the first span
    std::size_t first_flat_ = 0;  // least first span for which the cost is at its floor
    std::size_t last_flat_ = 0;   // last first span with the same total
};

void Cover::move_lower_bound(std::size_t last) {
    while (rules_.readable[run_].end <= spans_[last].start) {
        ++run_;
        TAKT_ASSERT(run_ < rules_.readable.size());
    }
    const std::uint32_t reach = reach_[last];
    TAKT_ASSERT(rules_.readable[run_].start <= spans_[last].start && reach <= rules_.readable[run_].end);
    const std::uint32_t start =
        std::max(rules_.readable[run_].start, reach > rules_.limit ? reach - rules_.limit : 0);
    while (spans_[least_].start < start) ++least_;
    TAKT_ASSERT(least_ <= last);
}

void Cover::admit_candidates(std::size_t last) {
    first_flat_ = std::max(first_flat_, least_);
    const RequestCost& cost = rules_.cost;
    for (; first_flat_ <= last && reach_[last] - spans_[first_flat_].start > at_floor_; ++first_flat_) {
        const std::uint32_t start = spans_[first_flat_].start;
        const Total& before = totals_[first_flat_];
        candidates_[start % cost.unit].push(
            {{before.cost - cost.step * (start / cost.unit), before.requests}, first_flat_});
    }
}

Choice Cover::best_choice(std::size_t last) {
    const RequestCost& cost = rules_.cost;
    Choice best;
    bool found = first_flat_ <= last;
    if (found) {
        last_flat_ = std::max(last_flat_, first_flat_);
        while (last_flat_ < last && totals_[last_flat_ + 1] == totals_[first_flat_]) ++last_flat_;
        best = {{totals_[last_flat_].cost + cost.floor, totals_[last_flat_].requests}, last_flat_};
    }
    for (std::uint32_t remainder = 0; remainder < cost.unit; ++remainder) {
        Candidates& candidates = candidates_[remainder];
        candidates.drop_before(least_);
        if (candidates.empty()) continue;
        Choice choice = candidates.best();
        choice.total.cost += cost.base + cost.step * ((reach_[last] - remainder + cost.unit - 1) / cost.unit);
        if (!found || choice.better_than(best)) best = choice;
        found = true;
    }
    TAKT_ASSERT(found);
    ++best.total.requests;
    return best;
}

std::vector<Window> Cover::windows() {
    std::uint32_t reach = 0;
    for (std::size_t i = 0; i < spans_.size(); ++i) {
        reach = std::max(reach, spans_[i].end);
        reach_[i] = reach;
        move_lower_bound(i);
        admit_candidates(i);
        const Choice choice = best_choice(i);
        totals_[i + 1] = choice.total;
        firsts_[i] = static_cast<std::uint32_t>(choice.first);
    }
    std::vector<Window> windows;
    for (std::size_t end = spans_.size(); end > 0; end = windows.back().first) {
        const std::size_t first = firsts_[end - 1];
        windows.push_back({{spans_[first].start, reach_[end - 1]}, first, end - 1});
    }
    std::reverse(windows.begin(), windows.end());
    return windows;
}

}  // namespace

std::vector<Window> cover(std::span<const Span> spans, const CoverRules& rules) {
    TAKT_ASSERT(rules.limit > 0 && rules.cost.unit > 0);
    return Cover(spans, rules).windows();
}

std::vector<Span> united(std::span<const Span> spans) {
    std::vector<Span> runs;
    for (const Span& span : spans) {
        if (runs.empty() || runs.back().end < span.start)
            runs.push_back(span);
        else
            runs.back().end = std::max(runs.back().end, span.end);
    }
    return runs;
}

}  // namespace takt::plan
