// Promotion: a local search that shortens periods so that spans can share requests. It moves, in this order,
// whole periods; spans that already lie inside requests of shorter periods; and single spans, in windows of a
// few neighbours, because the best period of a span depends only on its neighbourhood. A step is kept if it
// is better (Neighbourhood::better), so the search ends in a local minimum.
#include "timing/promotion.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace takt::plan {
namespace {

constexpr std::size_t kMostMovedPeriods = 8;
constexpr std::size_t kPasses = 2;
constexpr std::size_t kWindow = 16;

using Periods = std::vector<Duration>;

Duration multiple(Duration unit, Duration most) {
    return unit * (most / unit);
}

Periods distinct(Periods periods) {
    std::sort(periods.begin(), periods.end());
    periods.erase(std::unique(periods.begin(), periods.end()), periods.end());
    return periods;
}

// The longest multiples of `units` up to `most`, and `most` itself; `present` is excluded.
Periods choices(const Periods& units, Duration most, Duration present) {
    Periods found{most};
    for (const Duration unit : units)
        if (unit < most) found.push_back(multiple(unit, most));
    found = distinct(std::move(found));
    std::erase(found, present);
    return found;
}

bool each_divides_the_next(const Periods& periods) {
    return std::adjacent_find(periods.begin(), periods.end(), [](Duration a, Duration b) {
               return b % a != Duration::zero();
           }) == periods.end();
}

// `requests`: ascending start and end.
bool lies_in_one(const Span& items, const std::vector<Span>& requests) {
    const auto after = std::upper_bound(requests.begin(), requests.end(), items.start,
                                        [](std::uint32_t start, const Span& r) { return start < r.start; });
    return after != requests.begin() && items.end <= std::prev(after)->end;
}

class PromotionSearch {
public:
    PromotionSearch(Neighbourhood& neighbourhood, std::size_t& trials)
        : neighbourhood_(neighbourhood),
          trials_(trials),
          best_(neighbourhood.timetable(neighbourhood.alone().periods)),
          own_(distinct(neighbourhood.alone().periods)) {}

    Timetable least();

private:
    void consider(Periods periods);
    void round_down();
    void move_periods();
    void let_ride();
    void move_spans();
    void move_spans(std::size_t first, std::size_t count, Periods& periods);
    [[nodiscard]] Periods with(const Periods& rounded) const;

    Neighbourhood& neighbourhood_;
    std::size_t& trials_;
    Timetable best_;
    Periods own_;
};

Timetable PromotionSearch::least() {
    const bool harmonic = each_divides_the_next(own_);
    if (harmonic && best_.blocks.size() == 1) return best_;
    if (!harmonic) {
        round_down();
        if (own_.size() <= kMostMovedPeriods) move_periods();
    }
    let_ride();
    if (!harmonic) move_spans();
    const Timetable& alone = neighbourhood_.alone();
    return best_.utilization <= alone.utilization ? best_ : alone;
}

void PromotionSearch::consider(Periods periods) {
    Timetable made = neighbourhood_.timetable(std::move(periods));
    if (neighbourhood_.better(made, best_)) best_ = std::move(made);
}

// The period from `rounded` for each span, matched by the span's own period in own_.
Periods PromotionSearch::with(const Periods& rounded) const {
    Periods periods = neighbourhood_.alone().periods;
    for (std::size_t i = 0; i < periods.size(); ++i) {
        if (neighbourhood_.spans()[i].fixed) continue;
        const auto at = std::lower_bound(own_.begin(), own_.end(), periods[i]);
        periods[i] = rounded[static_cast<std::size_t>(at - own_.begin())];
    }
    return periods;
}

void PromotionSearch::round_down() {
    Periods to_first = own_;
    Periods to_previous = own_;
    for (std::size_t i = 1; i < own_.size(); ++i) {
        to_first[i] = multiple(own_[0], own_[i]);
        to_previous[i] = multiple(to_previous[i - 1], own_[i]);
    }
    consider(with(to_first));
    consider(with(to_previous));
}

void PromotionSearch::move_periods() {
    Periods rounded = own_;
    for (std::size_t span = 0; span < best_.periods.size(); ++span) {
        const auto& [items, own, fixed] = neighbourhood_.spans()[span];
        const auto at = std::lower_bound(own_.begin(), own_.end(), own) - own_.begin();
        if (!fixed) rounded[static_cast<std::size_t>(at)] = best_.periods[span];
    }
    for (std::size_t pass = 0; pass < kPasses; ++pass) {
        for (std::size_t i = 1; i < own_.size(); ++i) {
            Periods units = own_;
            units.insert(units.end(), rounded.begin(), rounded.end());
            for (const Duration choice : choices(units, own_[i], rounded[i])) {
                Periods tried = rounded;
                tried[i] = choice;
                Timetable made = neighbourhood_.timetable(with(tried));
                if (!neighbourhood_.better(made, best_)) continue;
                best_ = std::move(made);
                rounded = std::move(tried);
            }
        }
    }
}

void PromotionSearch::let_ride() {
    for (const Duration period : distinct(best_.periods)) {
        const auto read = neighbourhood_.read_with(best_, period);
        Periods periods = best_.periods;
        for (std::size_t i = 0; i < periods.size(); ++i) {
            const auto& [items, own, fixed] = neighbourhood_.spans()[i];
            if (!fixed && periods[i] > period && lies_in_one(items, read)) periods[i] = period;
        }
        if (periods != best_.periods) consider(std::move(periods));
    }
}

void PromotionSearch::move_spans() {
    Periods periods = best_.periods;
    for (std::size_t first = 0; first < periods.size() && trials_ > 0; first += kWindow)
        move_spans(first, std::min(kWindow, periods.size() - first), periods);
    if (periods != best_.periods) consider(std::move(periods));
}

void PromotionSearch::move_spans(std::size_t first, std::size_t count, Periods& periods) {
    Neighbourhood window(neighbourhood_.spans().subspan(first, count), neighbourhood_.rules(),
                         neighbourhood_.calendars());
    const auto begin = periods.begin() + static_cast<std::ptrdiff_t>(first);
    const auto end = begin + static_cast<std::ptrdiff_t>(count);
    Timetable best = window.timetable(Periods(begin, end));
    for (std::size_t pass = 0; pass < kPasses; ++pass) {
        for (std::size_t i = 0; i < count; ++i) {
            const Duration own = window.spans()[i].period;
            if (window.spans()[i].fixed) continue;
            for (const Duration choice : choices(distinct(best.periods), own, best.periods[i])) {
                if (trials_ == 0) return;
                --trials_;
                Periods tried = best.periods;
                tried[i] = choice;
                Timetable made = window.timetable(std::move(tried));
                if (window.better(made, best)) best = std::move(made);
            }
        }
    }
    std::copy(best.periods.begin(), best.periods.end(), begin);
}

}  // namespace

Timetable least_timetable(Neighbourhood& neighbourhood, std::size_t& trials) {
    return PromotionSearch(neighbourhood, trials).least();
}

}  // namespace takt::plan
