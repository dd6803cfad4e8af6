// Response-time analysis for fixed priority without preemption (docs/guarantees.md, "Fixed priority without
// preemption"; George, Rivierre, Spuri 1996). Levels of equal priority are analysed from the most urgent one
// down:
//   1. the level's longest busy period is the least fixpoint of its demand;
//   2. for each job in it, the latest start of the job's last frame is a second fixpoint;
//   3. the response is that start + the last frame - the release. The loop ends when the arrival rates prove
//      that no later job can be slower.
// Each fixpoint iteration starts at a lower bound that follows from the rates alone. The total work is
// limited; beyond the limit the bound by rates is used, which is larger but still valid.
#include "takt/plan/response.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>

#include "timing/demand.hpp"

namespace takt::plan {
namespace {

constexpr std::size_t kMostSequentialDeadTasks = 10'000'000;  // devices times tasks

/// A task, or the demand that it has left when its device is dead.
struct RankedDemand {
    const Demand* demand = nullptr;
    Arrivals arrivals;
    Microseconds failure = 0;
    Microseconds blocking = 0;  // longest frame with which it blocks more urgent tasks
    std::uint32_t priority = 0;
    std::size_t task = 0;
    bool wanted = true;
    bool apart = false;  // forms its own level

    [[nodiscard]] bool only_blocks() const { return arrivals.period == 0; }
    [[nodiscard]] bool equals(const RankedDemand& other) const {
        if (apart || other.apart) return false;
        return only_blocks() == other.only_blocks() && (only_blocks() || priority == other.priority);
    }
};

/// The inputs common to all members of one priority level.
struct Level {
    const Interference& higher;
    const Interference& equal;  // all members of the level
    const Failures& failures;
    Microseconds blocking = 0;
    Microseconds failure = 0;  // F_max of this and all more urgent levels
    Microseconds late = 0;     // longest late response of this level
    std::optional<Microseconds> busy;
};

class LevelAnalysis {
public:
    /// @param limit  of effort.spent
    LevelAnalysis(const Failures& failures, Effort& effort, std::uint64_t limit)
        : failures_(failures), higher_(failures_), equal_(failures_), effort_(effort), limit_(limit) {}

    /// @param entries  ascending priority, most urgent first; entries that only block come last
    /// @param longest  by task; raised where the response is longer. An empty value means unbounded and stays
    void run(std::span<const RankedDemand> entries, Responses& longest);

private:
    void run_level(std::span<const RankedDemand> members, Microseconds blocking, Responses& longest);
    std::optional<Microseconds> busy_period(const Level& level);
    std::optional<Microseconds> response(const Level& level, const RankedDemand& entry, Microseconds least);
    std::optional<Microseconds> start_of_last(const Level& level, WideTime before, Microseconds last,
                                              Microseconds late);
    /// The least t >= from with demand(t) <= t. `demand` must be monotone.
    template <class Function>
    std::optional<Microseconds> fixpoint(double from, std::size_t terms, Function demand);
    [[nodiscard]] static double bound_by_rates(const Level& level, const RankedDemand& entry,
                                               std::int64_t job);
    [[nodiscard]] bool exhausted() {
        if (effort_.spent > limit_) effort_.exhausted = true;
        return effort_.spent > limit_;
    }

    const Failures& failures_;
    Interference higher_;
    Interference equal_;  // of the present level
    Microseconds failure_ = 0;
    Effort& effort_;
    std::uint64_t limit_;
    std::vector<Demand::Ending> endings_;
};

Microseconds nominal_release(const Arrivals& arrivals, std::int64_t job) {
    const std::int64_t periods = std::max<std::int64_t>(0, job - arrivals.burst + 1);
    return periods * arrivals.period - arrivals.jitter;
}

double failure_load(const Level& level, Microseconds late) {
    return level.failures.rate() * static_cast<double>(level.failure + late);
}

void LevelAnalysis::run(std::span<const RankedDemand> entries, Responses& longest) {
    std::vector<Microseconds> blocking(entries.size() + 1, 0);
    for (std::size_t i = entries.size(); i-- > 0;)
        blocking[i] = std::max(blocking[i + 1], entries[i].blocking);
    std::size_t begin = 0;
    // Where the more urgent tasks alone exceed the line, no level has a bound any more.
    while (begin < entries.size() && !entries[begin].only_blocks() && higher_.rate() <= 1 + kRateRounding) {
        std::size_t end = begin + 1;
        while (end < entries.size() && entries[end].equals(entries[begin])) ++end;
        run_level(entries.subspan(begin, end - begin), blocking[end], longest);
        begin = end;
    }
    for (const RankedDemand& entry : entries.subspan(begin))
        if (entry.wanted) longest[entry.task].reset();
}

void LevelAnalysis::run_level(std::span<const RankedDemand> members, Microseconds blocking,
                              Responses& longest) {
    equal_.clear();
    Microseconds late = 0;
    bool wanted = false;
    for (const RankedDemand& member : members) {
        equal_.add(member.arrivals, *member.demand);
        failure_ = std::max(failure_, member.failure);
        late = std::max(late, member.arrivals.late);
        wanted = wanted || (member.wanted && longest[member.task]);
    }
    Level level{higher_, equal_, failures_, blocking, failure_, late, std::nullopt};
    if (wanted) level.busy = busy_period(level);
    for (const RankedDemand& member : members) {
        auto& known = longest[member.task];
        if (!member.wanted || !known) continue;
        known = level.busy ? response(level, member, *known) : std::nullopt;
    }
    for (const RankedDemand& member : members) higher_.add(member.arrivals, *member.demand);
}

template <class Function>
std::optional<Microseconds> LevelAnalysis::fixpoint(double from, std::size_t terms, Function demand) {
    if (!(from < static_cast<double>(kLongestBusyPeriod))) return std::nullopt;
    auto t = std::max<Microseconds>(0, static_cast<Microseconds>(from * (1 - kRateRounding)) - 1);
    while (!exhausted()) {
        effort_.spent += terms;
        const WideTime needed = demand(t);
        if (needed <= t) return t;
        if (needed > kLongestBusyPeriod) return std::nullopt;
        t = static_cast<Microseconds>(needed);
    }
    return std::nullopt;
}

std::optional<Microseconds> LevelAnalysis::busy_period(const Level& level) {
    const double faults = failure_load(level, level.late);
    if (level.higher.rate() + level.equal.rate() + faults > 1 + kRateRounding) return std::nullopt;
    const WideTime coefficient = level.failure + level.late;
    const double spare = 1 - level.higher.least_rate() - level.equal.least_rate();
    // Lower bound by the rates alone. A half-open window loses less than one job of each task.
    const double sure = static_cast<double>(level.blocking) + level.higher.least() + level.equal.least();
    const double from = spare > kRateRounding ? std::max(0.0, sure / spare) : 0;
    const auto demand = [&](Microseconds t) {
        const Microseconds window = std::max<Microseconds>(t, 1);
        return level.blocking + level.higher.half_open(window) + level.equal.half_open(window) +
               level.failures.within(window) * coefficient;
    };
    const auto busy = fixpoint(from * (1 - 1e-6) - 1, level.higher.terms() + level.equal.terms(), demand);
    if (busy) return std::max<Microseconds>(*busy, 1);
    if (exhausted()) return kLongestBusyPeriod;
    return std::nullopt;
}

std::optional<Microseconds> LevelAnalysis::start_of_last(const Level& level, WideTime before,
                                                         Microseconds last, Microseconds late) {
    const double spare = 1 - level.higher.least_rate();
    const double from = (static_cast<double>(before) + level.higher.least()) / std::max(spare, kRateRounding);
    return fixpoint(from, level.higher.terms(), [&](Microseconds t) {
        return before + level.higher.closed(t) +
               level.failures.within(t + last) * (WideTime{level.failure} + late);
    });
}

// An upper bound of the response of job `job` and every later one, from the arrival rates alone.
double LevelAnalysis::bound_by_rates(const Level& level, const RankedDemand& entry, std::int64_t job) {
    const auto release = static_cast<double>(nominal_release(entry.arrivals, job));
    const Demand& own = *entry.demand;
    const double faults = failure_load(level, entry.arrivals.late);
    const double spare = 1 - level.higher.rate() - faults;
    if (spare <= kRateRounding) return static_cast<double>(kLongestBusyPeriod) * 2;
    const double last = static_cast<double>(own.longest_frame());
    const double failed = static_cast<double>(level.failure + entry.arrivals.late) *
                          (level.failures.most_at_once() + level.failures.rate() * last);
    const double equals = level.equal.most() + level.equal.rate() * std::max(0.0, release);
    const double sum = static_cast<double>(level.blocking) + static_cast<double>(job + 1) * own.mean() +
                       own.slack() + equals + level.higher.most() + failed;
    return (sum / spare + last - release) * (1 + kRateRounding) + 1;
}

std::optional<Microseconds> LevelAnalysis::response(const Level& level, const RankedDemand& entry,
                                                    Microseconds least) {
    const Arrivals& arrivals = entry.arrivals;
    const std::int64_t burst = arrivals.burst;
    const auto by_rates = [&](std::int64_t job) { return bound_by_rates(level, entry, job); };
    Microseconds longest = least;
    const std::int64_t jobs = arrivals.half_open(*level.busy);
    for (std::int64_t job = 0; job < jobs; ++job) {
        ++effort_.spent;
        if (job + 1 >= burst && by_rates(job) <= static_cast<double>(longest)) break;
        const Microseconds release = nominal_release(arrivals, job);
        const Microseconds window = std::max<Microseconds>(0, release);
        const WideTime others = level.equal.closed(window) - entry.demand->most(arrivals.closed(window));
        effort_.spent += level.equal.terms();
        entry.demand->endings(job + 1, endings_);
        for (const auto& ending : endings_) {
            const WideTime before = level.blocking + ending.before + others;
            const auto start = start_of_last(level, before, ending.last, arrivals.late);
            if (!start) {
                if (!exhausted()) return std::nullopt;
                const double bound = by_rates(std::max(job, burst - 1));
                if (!(bound < static_cast<double>(kLongestBusyPeriod))) return std::nullopt;
                return std::max(longest, static_cast<Microseconds>(std::ceil(bound)));
            }
            longest = std::max(longest, *start + ending.last - release);
        }
    }
    return longest > kLongestBusyPeriod ? std::nullopt : std::optional(longest);
}

/// The tasks of one line in the order of the analysis, with their demands.
class SequentialAnalysis {
public:
    SequentialAnalysis(std::span<const Task> tasks, Effort* effort);

    [[nodiscard]] Responses responses(const std::optional<FaultRate>& faults);
    [[nodiscard]] Responses responses_with_dead_device();

private:
    void make_entries(bool failed_blocks);
    [[nodiscard]] Responses responses_with_any_dead();
    void run(const Failures& failures, Responses& longest);

    std::span<const Task> tasks_;
    std::vector<std::size_t> order_;
    std::vector<Demand> demands_;        // by task
    std::vector<RankedDemand> entries_;  // in order
    Effort own_;
    Effort& effort_;
    std::uint64_t limit_;
};

SequentialAnalysis::SequentialAnalysis(std::span<const Task> tasks, Effort* effort)
    : tasks_(tasks),
      order_(tasks.size()),
      effort_(effort ? *effort : own_),
      limit_(effort_.spent + effort_.most) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::stable_sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
        const bool a_blocks = tasks[a].period == 0;
        const bool b_blocks = tasks[b].period == 0;
        return a_blocks != b_blocks ? b_blocks : tasks[a].priority < tasks[b].priority;
    });
    demands_.reserve(tasks.size());
    for (const Task& task : tasks) demands_.emplace_back(task);
}

void SequentialAnalysis::make_entries(bool failed_blocks) {
    entries_.clear();
    entries_.reserve(tasks_.size());
    for (const std::size_t i : order_) {
        const Task& task = tasks_[i];
        const Demand& demand = demands_[i];
        entries_.push_back({.demand = &demand,
                            .arrivals = {task.period, task.jitter, task.late, task.burst},
                            .failure = task.failure,
                            .blocking = failed_blocks ? task.failure : demand.longest_frame(),
                            .priority = task.priority,
                            .task = i});
    }
}

void SequentialAnalysis::run(const Failures& failures, Responses& longest) {
    LevelAnalysis(failures, effort_, limit_).run(entries_, longest);
}

Responses SequentialAnalysis::responses(const std::optional<FaultRate>& faults) {
    Responses longest(tasks_.size(), Microseconds{0});
    make_entries(false);
    if (!faults) {
        run(Failures(), longest);
        return longest;
    }
    run(Failures(*faults, 0), longest);
    make_entries(true);
    run(Failures(*faults, 1), longest);
    return longest;
}

Responses SequentialAnalysis::responses_with_dead_device() {
    std::vector<std::uint32_t> devices;
    for (const Task& task : tasks_) devices.push_back(task.device);
    std::sort(devices.begin(), devices.end());
    devices.erase(std::unique(devices.begin(), devices.end()), devices.end());
    std::erase(devices, kNoDevice);
    if (devices.size() < 2) return responses(std::nullopt);
    if (devices.size() * tasks_.size() > kMostSequentialDeadTasks) return responses_with_any_dead();
    std::vector<Demand> dead;
    dead.reserve(tasks_.size());
    for (const Task& task : tasks_) dead.emplace_back(task.failure, task.attempts);
    Responses longest(tasks_.size(), Microseconds{0});
    make_entries(false);
    std::vector<std::size_t> by_device(entries_.size());
    std::iota(by_device.begin(), by_device.end(), std::size_t{0});
    std::stable_sort(by_device.begin(), by_device.end(), [this](std::size_t a, std::size_t b) {
        return tasks_[entries_[a].task].device < tasks_[entries_[b].task].device;
    });
    std::vector<RankedDemand> alive;
    for (auto own = by_device.begin(); own != by_device.end();) {
        const std::uint32_t device = tasks_[entries_[*own].task].device;
        const auto end = std::find_if(
            own, by_device.end(), [&](std::size_t i) { return tasks_[entries_[i].task].device != device; });
        if (device == kNoDevice) break;  // the last one
        alive.clear();
        for (auto i = own; i != end; ++i) alive.push_back(entries_[*i]);
        for (auto i = own; i != end; ++i) {
            RankedDemand& entry = entries_[*i];
            const Task& task = tasks_[entry.task];
            entry.wanted = false;
            entry.demand = &dead[entry.task];
            entry.blocking = task.failure;
            if (!entry.only_blocks()) entry.arrivals.period = std::max(task.period, task.backoff);
        }
        run(Failures(), longest);
        for (const RankedDemand& entry : alive) entries_[*own++] = entry;
    }
    return longest;
}

// With too many devices for one analysis each, one pseudo task at the top priority represents any dead
// device: its demand, failure time and arrivals are the worst of all devices. The bound is valid but larger.
Responses SequentialAnalysis::responses_with_any_dead() {
    std::map<std::uint32_t, WideTime> sums;
    Task worst;
    Microseconds most = 0;
    for (const Task& task : tasks_) {
        if (task.device == kNoDevice) continue;
        WideTime& sum = sums[task.device];
        sum += WideTime{task.failure} * task.attempts;
        most =
            static_cast<Microseconds>(std::max<WideTime>(most, std::min(sum, WideTime{kLongestBusyPeriod})));
        worst.failure = std::max(worst.failure, task.failure);
        if (task.period == 0) continue;
        const Microseconds period = std::max(task.period, task.backoff);
        worst.period = worst.period == 0 ? period : std::min(worst.period, period);
        worst.jitter = std::max(worst.jitter, task.jitter);
        worst.burst = std::max(worst.burst, task.burst);
    }
    Responses longest(tasks_.size(), Microseconds{0});
    if (worst.period == 0) return Responses(tasks_.size());
    make_entries(true);
    const Demand demand(most, 1);
    entries_.insert(entries_.begin(), RankedDemand{.demand = &demand,
                                                   .arrivals = {worst.period, worst.jitter, 0, worst.burst},
                                                   .failure = worst.failure,
                                                   .wanted = false,
                                                   .apart = true});
    run(Failures(), longest);
    return longest;
}

}  // namespace

Responses response_times(std::span<const Task> tasks, Effort* effort) {
    return SequentialAnalysis(tasks, effort).responses(std::nullopt);
}

Responses response_times_with_faults(std::span<const Task> tasks, const FaultRate& faults, Effort* effort) {
    return SequentialAnalysis(tasks, effort).responses(faults);
}

Responses response_times_with_dead_device(std::span<const Task> tasks, Effort* effort) {
    return SequentialAnalysis(tasks, effort).responses_with_dead_device();
}

double utilization(std::span<const Task> tasks) {
    double sum = 0;
    for (const Task& task : tasks)
        if (task.period > 0) sum += Demand(task).mean() / static_cast<double>(task.period);
    return sum;
}

}  // namespace takt::plan
