// The spans are first divided into neighbourhoods, which are planned independently. Two spans belong to
// different neighbourhoods if joining them never pays: two requests of one item each cost no more than one
// request of the gap and both items. Wider spans only make joining dearer, so the test holds for any due set.
#include "requests/rounds.hpp"

#include <algorithm>
#include <tuple>

#include "takt/base/assert.hpp"

namespace takt::plan {
namespace {

bool may_join(std::uint32_t gap, const CoverRules& rules) {
    return gap + 2 <= rules.limit && rules.cost(gap + 2) < 2 * rules.cost(1);
}

class Rounds {
public:
    Rounds(std::span<const TimedSpan> spans, const CoverRules& rules) : spans_(spans), rules_(rules) {}

    std::vector<TimedWindow> requests();

private:
    [[nodiscard]] std::size_t end_of_neighbourhood(std::size_t first);
    void add(std::size_t first, std::size_t end);

    std::span<const TimedSpan> spans_;
    CoverRules rules_;
    std::size_t run_ = 0;  // the readable run of the present neighbourhood
    Calendars calendars_;
    std::size_t trials_ = kMostTrials;
    std::vector<TimedWindow> requests_;
};

std::vector<TimedWindow> Rounds::requests() {
    for (std::size_t first = 0, end = 0; first < spans_.size(); first = end) {
        end = end_of_neighbourhood(first);
        add(first, end);
    }
    return std::move(requests_);
}

std::size_t Rounds::end_of_neighbourhood(std::size_t first) {
    while (rules_.readable[run_].end <= spans_[first].items.start) {
        ++run_;
        TAKT_ASSERT(run_ < rules_.readable.size());
    }
    std::uint32_t reach = spans_[first].items.end;
    std::size_t end = first + 1;
    for (; end < spans_.size(); ++end) {
        const Span& next = spans_[end].items;
        if (next.start >= rules_.readable[run_].end) break;
        if (next.start > reach && !may_join(next.start - reach, rules_)) break;
        reach = std::max(reach, next.end);
    }
    return end;
}

void Rounds::add(std::size_t first, std::size_t end) {
    CoverRules rules = rules_;
    rules.readable = rules_.readable.subspan(run_, 1);
    Neighbourhood neighbourhood(spans_.subspan(first, end - first), rules, calendars_);
    for (TimedWindow& request : neighbourhood.requests(least_timetable(neighbourhood, trials_))) {
        for (std::size_t& span : request.spans) span += first;
        requests_.push_back(std::move(request));
    }
}

}  // namespace

std::vector<TimedWindow> rounds(std::span<const TimedSpan> spans, const CoverRules& rules) {
    return Rounds(spans, rules).requests();
}

}  // namespace takt::plan
