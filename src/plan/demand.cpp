#include "demand.hpp"

#include <algorithm>

namespace takt::plan {

Demand::Demand(const Task& task) {
    if (task.shapes.empty()) {
        add_shape(task.frames);
    } else {
        for (const auto& shape : task.shapes) add_shape(shape);
    }
    most_.assign(totals_.size(), WideTime{-1});
}

Demand::Demand(Microseconds frame, std::uint32_t frames) : most_(1, WideTime{-1}) {
    totals_.push_back(WideTime{frame} * frames);
    sums_.push_back(totals_.back());
    lasts_.push_back(frame);
    longest_frame_ = frame;
}

void Demand::add_shape(const std::vector<Microseconds>& frames) {
    WideTime total = 0;
    for (const Microseconds frame : frames) {
        total += frame;
        longest_frame_ = std::max(longest_frame_, frame);
    }
    totals_.push_back(total);
    sums_.push_back(sums_.back() + total);
    lasts_.push_back(frames.empty() ? 0 : frames.back());
}

double Demand::mean() const {
    return static_cast<double>(sums_.back()) / static_cast<double>(totals_.size());
}

double Demand::slack() const {
    return cyclic() ? static_cast<double>(sums_.back()) : 0;
}

WideTime Demand::ending_at(std::size_t shape, std::int64_t jobs) const {
    const auto rest = static_cast<std::size_t>(jobs % shapes());
    const WideTime cycles = sums_.back() * (jobs / shapes());
    const std::size_t end = shape + 1;
    if (rest <= end) return cycles + sums_[end] - sums_[end - rest];
    return cycles + sums_[end] + sums_.back() - sums_[end + totals_.size() - rest];
}

WideTime Demand::most(std::int64_t jobs) const {
    if (!cyclic()) return totals_.front() * jobs;
    const std::int64_t rest = jobs % shapes();
    WideTime& known = most_[static_cast<std::size_t>(rest)];
    if (known < 0)
        for (std::size_t shape = 0; shape < totals_.size(); ++shape)
            known = std::max(known, ending_at(shape, rest));
    return sums_.back() * (jobs / shapes()) + known;
}

void Demand::endings(std::int64_t jobs, std::vector<Ending>& to) const {
    to.clear();
    for (std::size_t shape = 0; shape < totals_.size(); ++shape)
        if (lasts_[shape] > 0) to.push_back({ending_at(shape, jobs) - lasts_[shape], lasts_[shape]});
    std::sort(to.begin(), to.end(), [](const Ending& a, const Ending& b) {
        return a.before != b.before ? a.before > b.before : a.last > b.last;
    });
    Microseconds longest = 0;
    std::erase_if(to, [&longest](const Ending& ending) {
        if (ending.last <= longest) return true;
        longest = ending.last;
        return false;
    });
}

void Interference::add(const Arrivals& arrivals, const Demand& demand) {
    const double period = static_cast<double>(arrivals.period);
    const double each = demand.mean();
    const double jitter = static_cast<double>(arrivals.jitter);
    const double late = static_cast<double>(arrivals.late);
    rate_ += each / period * (1 + late * failures_->rate());
    least_rate_ += each / period;
    most_ += each * (arrivals.burst + (jitter + late * failures_->most_at_once()) / period) + demand.slack();
    least_ += each * (arrivals.burst - 1 + jitter / period);
    if (demand.cyclic()) {
        cyclic_.push_back({arrivals, &demand});
        return;
    }
    Term& term = term_of(arrivals);
    term.arrivals.burst = 0;
    term.at_once += demand.most(arrivals.burst);
    term.each += demand.most(1);
}

// There are usually few distinct arrivals, so a linear search is faster than a map.
Interference::Term& Interference::term_of(const Arrivals& arrivals) {
    constexpr std::size_t kFew = 16;
    const auto few = terms_.begin() + static_cast<std::ptrdiff_t>(std::min(terms_.size(), kFew));
    const auto same = std::find_if(terms_.begin(), few, [&](const Term& term) {
        return term.arrivals.period == arrivals.period && term.arrivals.jitter == arrivals.jitter &&
               term.arrivals.late == arrivals.late;
    });
    if (same != few) return *same;
    if (terms_.size() >= kFew) {
        const auto key = std::tuple(arrivals.period, arrivals.jitter, arrivals.late);
        const auto [known, is_new] = index_.try_emplace(key, terms_.size());
        if (!is_new) return terms_[known->second];
    }
    return terms_.emplace_back(Term{arrivals});
}

WideTime Interference::sum(Microseconds t, Microseconds open) const {
    const WideTime failed = failures_->within(t);
    const auto window = [&](const Arrivals& arrivals) {
        const WideTime held = std::min(failed * arrivals.late, WideTime{kLongestBusyPeriod});
        return t - open + static_cast<Microseconds>(held);
    };
    WideTime sum = 0;
    for (const Term& term : terms_)
        sum += term.at_once + term.each * term.arrivals.closed(window(term.arrivals));
    for (const Cyclic& task : cyclic_) sum += task.demand->most(task.arrivals.closed(window(task.arrivals)));
    return sum;
}

WideTime Interference::closed(Microseconds t) const {
    return sum(t, 0);
}

WideTime Interference::half_open(Microseconds t) const {
    return sum(t, 1);
}

}  // namespace takt::plan
