// Earliest deadline first without preemption (docs/guarantees.md, "Earliest deadline first without
// preemption"). The line is feasible if, for each absolute deadline t, the demand of all jobs with a deadline
// at or before t, plus the longest frame that can block them, does not exceed t.
#include <algorithm>
#include <cstddef>
#include <functional>
#include <map>
#include <queue>
#include <tuple>
#include <utility>

#include "takt/plan/response.hpp"
#include "timing/demand.hpp"

namespace takt::plan {
namespace {

constexpr std::size_t kMostPoints = 2'000'000;
constexpr std::size_t kMostSteps = 100'000;

/// A step of the demand: jobs with the common deadlines first + n * period.
struct Source {
    Microseconds first = 0;
    Microseconds period = 0;
    WideTime at_once = 0;            // demand of the first deadline
    WideTime each = 0;               // of every further one
    const Demand* cyclic = nullptr;  // instead of both: of `jobs` so far
    std::int64_t jobs = 0;           // at the next deadline
    WideTime demanded = 0;           // up to the last one
};

/// Blocking: a frame that has just begun and whose own deadline is later than t.
class Blocking {
public:
    void add(Microseconds deadline, Microseconds frame) { frames_.emplace_back(deadline, frame); }
    void finish();
    [[nodiscard]] Microseconds beyond(Microseconds t) const;

private:
    std::vector<std::pair<Microseconds, Microseconds>> frames_;  // deadline; the longest of it and later
};

void Blocking::finish() {
    std::sort(frames_.begin(), frames_.end());
    for (std::size_t i = frames_.size(); i-- > 1;)
        frames_[i - 1].second = std::max(frames_[i - 1].second, frames_[i].second);
}

Microseconds Blocking::beyond(Microseconds t) const {
    const auto later =
        std::upper_bound(frames_.begin(), frames_.end(), t,
                         [](Microseconds limit, const auto& frame) { return limit < frame.first; });
    return later == frames_.end() ? 0 : later->second;
}

/// Visits all deadlines up to a limit in ascending order and accumulates the demand.
class Sweep {
public:
    void add(Source source) { sources_.push_back(source); }
    /// @param holds  (t, demand up to t); whether the sweep goes on
    /// @returns whether it went on to the end
    bool run(Microseconds limit, const std::function<bool(Microseconds, WideTime)>& holds);

private:
    std::vector<Source> sources_;
};

WideTime next_demand(Source& source) {
    if (!source.cyclic) return std::exchange(source.at_once, source.each);
    const WideTime sum = source.cyclic->most(source.jobs++);
    return sum - std::exchange(source.demanded, sum);
}

bool Sweep::run(Microseconds limit, const std::function<bool(Microseconds, WideTime)>& holds) {
    using Next = std::pair<Microseconds, std::size_t>;
    std::priority_queue<Next, std::vector<Next>, std::greater<>> queue;
    for (std::size_t i = 0; i < sources_.size(); ++i) queue.emplace(sources_[i].first, i);
    WideTime demand = 0;
    for (std::size_t points = 0; !queue.empty() && queue.top().first <= limit;) {
        const auto [t, index] = queue.top();
        queue.pop();
        if (++points > kMostPoints) return false;
        demand += next_demand(sources_[index]);
        queue.emplace(t + sources_[index].period, index);
        if (queue.top().first != t && !holds(t, demand)) return false;
    }
    return true;
}

struct EdfLine {
    explicit EdfLine(std::span<const Task> tasks);

    std::span<const Task> tasks;
    std::vector<Demand> demands;
    double utilization = 0;
    Microseconds failure = 0;  // F_max
    Microseconds late = 0;
    Microseconds last_first_deadline = 0;
};

EdfLine::EdfLine(std::span<const Task> all) : tasks(all), utilization(plan::utilization(all)) {
    demands.reserve(tasks.size());
    for (const Task& task : tasks) {
        demands.emplace_back(task);
        failure = std::max(failure, task.failure);
        late = std::max(late, task.late);
        if (task.period > 0) last_first_deadline = std::max(last_first_deadline, task.deadline - task.jitter);
    }
}

Sweep sweep_of(const EdfLine& line) {
    std::map<std::tuple<Microseconds, Microseconds>, Source> alike;
    Sweep sweep;
    for (std::size_t i = 0; i < line.tasks.size(); ++i) {
        const Task& task = line.tasks[i];
        if (task.period == 0) continue;
        const Microseconds first = task.deadline - task.jitter;
        if (line.demands[i].cyclic()) {
            Source source{.first = first, .period = task.period, .cyclic = &line.demands[i]};
            source.jobs = task.burst;
            sweep.add(source);
            continue;
        }
        Source& source = alike.try_emplace({first, task.period}, Source{first, task.period}).first->second;
        source.at_once += line.demands[i].most(task.burst);
        source.each += line.demands[i].most(1);
    }
    for (const auto& [key, source] : alike) sweep.add(source);
    return sweep;
}

std::optional<Microseconds> edf_busy_period(const EdfLine& line, const Failures& failures,
                                            Microseconds blocking) {
    Interference all(failures);
    for (std::size_t i = 0; i < line.tasks.size(); ++i) {
        const Task& task = line.tasks[i];
        if (task.period > 0) all.add({task.period, task.jitter, task.late, task.burst}, line.demands[i]);
    }
    const double spare = 1 - all.least_rate();
    const double sure = static_cast<double>(blocking) + all.least();
    const double from = spare > kRateRounding ? std::max(0.0, sure / spare * (1 - 1e-6)) : 0;
    if (!(from < static_cast<double>(kLongestBusyPeriod))) return std::nullopt;
    auto t = std::max<Microseconds>(1, static_cast<Microseconds>(from) - 1);
    for (std::size_t step = 0; step < kMostSteps; ++step) {
        const WideTime needed =
            blocking + all.half_open(t) + failures.within(t) * (WideTime{line.failure} + line.late);
        if (needed <= t) return t;
        if (needed > kLongestBusyPeriod) return std::nullopt;
        t = static_cast<Microseconds>(needed);
    }
    return std::nullopt;
}

// The last deadline that must be checked. Frames that can always block lengthen every busy period; frames
// with a deadline of their own lengthen only the busy periods that begin before it.
std::optional<Microseconds> last_point(const EdfLine& line, const Failures& failures, Microseconds always,
                                       Microseconds at_most) {
    const auto busy = edf_busy_period(line, failures, always);
    if (!busy) return std::nullopt;
    const auto blocked = edf_busy_period(line, failures, at_most);
    return std::max(*busy, std::min(blocked.value_or(kLongestBusyPeriod), line.last_first_deadline));
}

bool holds(const EdfLine& line, const Failures& failures, bool failed_blocks) {
    Blocking blocking;
    Microseconds always = 0;
    for (std::size_t i = 0; i < line.tasks.size(); ++i) {
        const Task& task = line.tasks[i];
        const Microseconds frame = failed_blocks ? task.failure : line.demands[i].longest_frame();
        if (task.period == 0) always = std::max(always, frame);
        blocking.add(task.period == 0 ? kLongestBusyPeriod : task.deadline - task.jitter, frame);
    }
    blocking.finish();
    const auto limit = last_point(line, failures, always, blocking.beyond(-kLongestBusyPeriod));
    if (!limit) return false;
    return sweep_of(line).run(*limit, [&](Microseconds t, WideTime demand) {
        const WideTime failed =
            failures.within(std::max<Microseconds>(t, 0)) * (WideTime{line.failure} + line.late);
        return demand + failed + blocking.beyond(t) <= t;
    });
}

}  // namespace

bool feasible_edf(std::span<const Task> tasks, const std::optional<FaultRate>& faults) {
    const EdfLine line(tasks);
    if (line.utilization > 1 + kRateRounding) return false;
    if (!faults) return holds(line, Failures(), false);
    return holds(line, Failures(*faults, 0), false) && holds(line, Failures(*faults, 1), true);
}

}  // namespace takt::plan
