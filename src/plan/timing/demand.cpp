// A task whose demand differs from tick to tick is a cycle of shapes. n jobs in a row are some whole cycles
// and a rest that may end at any shape; the costliest end counts. sums[k] is the total of the first k
// shapes, so that each rest is one or two differences of prefix sums.
#include "timing/demand.hpp"

#include <algorithm>
#include <numeric>

namespace takt::plan {

Demand::Demand(const Task& task) {
    const auto note = [this](const std::vector<Microseconds>& frames) {
        for (const Microseconds frame : frames) {
            total_ += frame;
            longest_frame_ = std::max(longest_frame_, frame);
        }
        last_ = frames.empty() ? 0 : frames.back();
    };
    if (task.shapes.empty()) note(task.frames);
    for (const auto& shape : task.shapes) note(shape);
    if (task.shapes.size() > 1) cycle_ = std::make_unique<const Cycle>(task.shapes);
}

Demand::Demand(Microseconds frame, std::uint32_t frames)
    : total_(WideTime{frame} * frames), longest_frame_(frame), last_(frame) {}

Demand::Cycle::Cycle(const std::vector<std::vector<Microseconds>>& shapes)
    : most_of_few(shapes.size(), WideTime{-1}) {
    for (const auto& frames : shapes) {
        totals.push_back(std::accumulate(frames.begin(), frames.end(), WideTime{0}));
        sums.push_back(sums.back() + totals.back());
        lasts.push_back(frames.empty() ? 0 : frames.back());
    }
}

double Demand::mean() const {
    return static_cast<double>(total_) / static_cast<double>(cycle_ ? cycle_->shapes() : 1);
}

double Demand::slack() const {
    return cyclic() ? static_cast<double>(total_) : 0;
}

// The total of `jobs` jobs in a row whose last one has this shape. Where the rest begins before the first
// shape, its beginning is at the end of the cycle.
WideTime Demand::Cycle::ending_at(std::size_t shape, std::int64_t jobs) const {
    const auto rest = static_cast<std::size_t>(jobs % shapes());
    const WideTime cycles = sums.back() * (jobs / shapes());
    const std::size_t end = shape + 1;
    if (rest <= end) return cycles + sums[end] - sums[end - rest];
    return cycles + sums[end] + sums.back() - sums[end + totals.size() - rest];
}

WideTime Demand::Cycle::most(std::int64_t jobs) const {
    const std::int64_t rest = jobs % shapes();
    WideTime& known = most_of_few[static_cast<std::size_t>(rest)];
    if (known < 0)
        for (std::size_t shape = 0; shape < totals.size(); ++shape)
            known = std::max(known, ending_at(shape, rest));
    return sums.back() * (jobs / shapes()) + known;
}

// The Pareto front of the ends: sorted by the demand before the last frame, greatest first, a pair is kept
// only if its last frame is longer than those of all pairs before it. A shape without frames ends no job.
void Demand::endings(std::int64_t jobs, std::vector<Ending>& to) const {
    to.clear();
    if (!cycle_) {
        if (last_ > 0) to.push_back({total_ * jobs - last_, last_});
        return;
    }
    for (std::size_t shape = 0; shape < cycle_->totals.size(); ++shape)
        if (const Microseconds last = cycle_->lasts[shape]; last > 0)
            to.push_back({cycle_->ending_at(shape, jobs) - last, last});
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

std::size_t Interference::Hash::operator()(const Arrivals& arrivals) const {
    constexpr std::uint64_t kFactor = 0x9E3779B97F4A7C15;  // 2^64 / golden ratio
    std::uint64_t hash = 0;
    for (const Microseconds time : {arrivals.period, arrivals.jitter, arrivals.late}) {
        hash = (hash ^ static_cast<std::uint64_t>(time)) * kFactor;
        hash ^= hash >> 32;
    }
    return static_cast<std::size_t>(hash);
}

void Interference::clear() {
    index_.clear();
    terms_.clear();
    cyclic_.clear();
    at_once_ = 0;
    rate_ = least_rate_ = most_ = least_ = 0;
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
    at_once_ += demand.most(arrivals.burst);
    term_of(arrivals).each += demand.most(1);
}

// There are usually few distinct arrivals, so a linear search is faster than a hash.
Interference::Term& Interference::term_of(const Arrivals& arrivals) {
    constexpr std::size_t kFew = 16;
    const auto few = terms_.begin() + static_cast<std::ptrdiff_t>(std::min(terms_.size(), kFew));
    const auto same = std::find_if(terms_.begin(), few,
                                   [&](const Term& term) { return SameTerm()(term.arrivals, arrivals); });
    if (same != few) return *same;
    if (terms_.size() >= kFew) {
        const auto [known, is_new] = index_.try_emplace(arrivals, terms_.size());
        if (!is_new) return terms_[known->second];
    }
    return terms_.emplace_back(Term{Divisor(arrivals.period), arrivals.jitter, 0, arrivals});
}

WideTime Interference::sum(Microseconds t, Microseconds open) const {
    const WideTime failed = failures_->within(t);
    const auto window = [&](const Arrivals& arrivals) {
        const WideTime held = std::min(failed * arrivals.late, WideTime{kLongestBusyPeriod});
        return t - open + static_cast<Microseconds>(held);
    };
    WideTime sum = at_once_;
    if (failed == 0) {
        for (const Term& term : terms_) sum += term.each * term.period.divide(t - open + term.jitter);
    } else {
        for (const Term& term : terms_)
            sum += term.each * term.period.divide(window(term.arrivals) + term.jitter);
    }
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
