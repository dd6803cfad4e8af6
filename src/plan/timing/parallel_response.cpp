// Response times with k requests in flight: non-preemptive fixed priority on k identical slots. A task is in
// flight once at a time, so that during y of time it takes at most y of the slots (Bertogna, Cirinei 2007).
//
// A task is free if it has one transaction, no lane, and ends before its next release. Let t0 be the last
// instant before the release of a free job at which no job of its level waited. From t0 until it starts all
// slots are busy, and only jobs of its level start. Let w be this time:
//     k * w <= sum over the level of min(demand in w, w) + the k largest of what was in flight at t0
// A job of the level in flight at t0 was released within its bound R before t0. For k = 1 this is the
// busy-period analysis of one resource (response.cpp). (Guan, Stigge, Yi, Yu 2009 limit what is in flight in
// the same way.)
//
// Any other job may wait while a slot is free, for its lane or its own last transaction. Lower priorities
// start meanwhile. Its whole response R is then the window: a job of others that is active in it was released
// within its own bound before it. Of the time, a part is spent with all slots busy (shared by k), a part with
// a lane full (shared by the limit of the lane), a part with own earlier jobs. Each time that the lane or the
// own job ends its part, lower priorities may hold all slots once more ("turns").
//
// The bounds are a fixpoint of these inequalities, and therefore valid: the first job to exceed its bound
// would contradict its inequality, which needs only the bounds of jobs that ended before.
#include "timing/parallel_response.hpp"

#include <algorithm>
#include <functional>
#include <numeric>

#include "timing/demand.hpp"

namespace takt::plan {
namespace {

constexpr std::size_t kMostParallelDeadTasks = 100'000;  // devices times tasks
constexpr int kMostPeriodsPerResponse = 100;             // a longer response counts as unbounded

std::vector<std::vector<Microseconds>> shapes_of(const Task& task) {
    if (!task.shapes.empty()) return task.shapes;
    return {task.frames};
}

/// What is known of a task before the analysis.
struct TaskBound {
    explicit TaskBound(const Task& task) : demand(task) {
        for (const auto& shape : shapes_of(task)) {
            job = std::max(job, std::accumulate(shape.begin(), shape.end(), Microseconds{0}));
            frames = std::max(frames, static_cast<std::int64_t>(shape.size()));
            for (const auto each : shape) frame = std::max(frame, each);
        }
    }
    Demand demand;
    Microseconds job = 0;    // the longest one
    Microseconds frame = 0;  // likewise
    std::int64_t frames = 1;
    bool free = false;
    bool alone = false;
    std::vector<std::size_t> lanes;
    Microseconds response = 0;  // the bound so far
};

/// The work of one task; of a time it takes at most the whole of one slot.
struct SlotWork {
    WideTime started = 0;       ///< of jobs that start in this time
    WideTime with_carried = 0;  ///< with what was in flight before, at least `started`
};

/// The least work above a time.
WideTime next_limit(std::span<const SlotWork> works, WideTime time) {
    WideTime least = kLongestBusyPeriod;
    for (const auto& work : works) {
        for (const auto limit : {work.started, work.with_carried})
            if (limit > time) least = std::min(least, limit);
    }
    return least;
}

class ParallelAnalysis {
public:
    ParallelAnalysis(std::span<const Task> tasks, const Connection& connection, const Failures& failures,
                     Effort& effort);

    /// @returns by task; nothing: unbounded
    [[nodiscard]] Responses run();

private:
    using Tasks = std::vector<std::size_t>;
    /// The lanes of a task, during its response.
    struct LaneWait {
        WideTime full = 0;
        WideTime turns = 0;
        WideTime lower = 0;  // the longest transaction of lower priority, once in each lane
    };

    bool solve(std::span<const std::size_t> level);
    bool grow(std::size_t task);
    [[nodiscard]] std::optional<WideTime> bound_of_free(std::size_t task) const;
    [[nodiscard]] std::optional<WideTime> bound(std::size_t task) const;
    [[nodiscard]] std::optional<WideTime> start_of_free(std::size_t task, std::int64_t own) const;
    [[nodiscard]] WideTime busy_of_free(std::size_t task, std::int64_t own, Microseconds w) const;
    [[nodiscard]] WideTime work_within(std::span<const SlotWork> works, WideTime time) const;
    [[nodiscard]] WideTime all_busy(std::size_t task, WideTime turns) const;
    [[nodiscard]] LaneWait wait_for_lanes(std::size_t task) const;
    [[nodiscard]] WideTime largest(std::vector<WideTime>& parts) const;
    [[nodiscard]] std::int64_t started(std::size_t task, Microseconds window) const;
    [[nodiscard]] std::int64_t active(std::size_t task, Microseconds window) const {
        return releases(task, window, entries_[task].response);
    }
    [[nodiscard]] std::int64_t releases(std::size_t task, Microseconds window, Microseconds before) const {
        return tasks_[task].burst + (window + before) / tasks_[task].period;
    }
    /// Whether a request that goes alone goes before the task. While it waits, requests that go before it may
    /// start, one after the other, and the other slots are idle: their time is not shared.
    [[nodiscard]] bool waits_for_alone(std::size_t task) const {
        return std::ranges::any_of(before_, [&](std::size_t i) { return i != task && entries_[i].alone; });
    }
    [[nodiscard]] WideTime held_up(std::size_t task, std::int64_t jobs) const {
        return WideTime{jobs} *
               (WideTime{entries_[task].job} + WideTime{entries_[task].frames} * longest_frame_);
    }

    std::span<const Task> tasks_;
    const Connection& connection_;
    const Failures& failures_;
    Effort& effort_;
    std::uint64_t limit_;
    std::int64_t slots_;
    std::vector<TaskBound> entries_;
    Tasks before_;  // those of higher and equal priority
    Tasks lower_;
    Microseconds longest_frame_ = 0;
    Microseconds longest_failure_ = 0;
    bool has_alone_ = false;
};

ParallelAnalysis::ParallelAnalysis(std::span<const Task> tasks, const Connection& connection,
                                   const Failures& failures, Effort& effort)
    : tasks_(tasks),
      connection_(connection),
      failures_(failures),
      effort_(effort),
      limit_(effort.spent + effort.most),
      slots_(connection.in_flight),
      entries_(tasks.begin(), tasks.end()) {
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        TaskBound& entry = entries_[i];
        entry.alone = i < connection.alone.size() && connection.alone[i];
        has_alone_ = has_alone_ || entry.alone;
        entry.free = failures.rate() == 0 && tasks[i].burst == 1 && entry.frames <= 1 && !entry.alone;
        longest_frame_ = std::max(longest_frame_, entry.frame);
        longest_failure_ = std::max(longest_failure_, tasks[i].failure);
    }
    for (std::size_t lane = 0; lane < connection.lanes.size(); ++lane) {
        for (const auto task : connection.lanes[lane].tasks) {
            entries_[task].lanes.push_back(lane);
            entries_[task].free = false;
        }
    }
}

Responses ParallelAnalysis::run() {
    Tasks order;
    for (std::size_t i = 0; i < tasks_.size(); ++i) (tasks_[i].period > 0 ? order : lower_).push_back(i);
    std::ranges::stable_sort(order, {}, [this](std::size_t i) { return tasks_[i].priority; });
    lower_.insert(lower_.end(), order.rbegin(), order.rend());  // the most urgent ones are the last
    Responses responses(tasks_.size());
    for (std::size_t begin = 0; begin < order.size();) {
        std::size_t end = begin;
        while (end < order.size() && tasks_[order[end]].priority == tasks_[order[begin]].priority) ++end;
        const auto level = std::span(order).subspan(begin, end - begin);
        before_.insert(before_.end(), level.begin(), level.end());
        lower_.resize(lower_.size() - level.size());
        if (!solve(level)) break;  // no level below it has a bound either
        for (const auto i : level) responses[i] = entries_[i].response;
        begin = end;
    }
    return responses;
}

// @returns false: unbounded, or the effort is exhausted
bool ParallelAnalysis::solve(std::span<const std::size_t> level) {
    for (const auto i : level) entries_[i].response = tasks_[i].jitter + entries_[i].job;
    for (;;) {
        bool grew = false;
        for (const auto i : level) {
            const Microseconds known = entries_[i].response;
            const bool was_free = entries_[i].free;
            if (!grow(i)) return false;
            grew = grew || entries_[i].response != known || entries_[i].free != was_free;
        }
        if (!grew) return true;
    }
}

// Raises the bound of a task to what the present ones of the others give.
bool ParallelAnalysis::grow(std::size_t task) {
    const Task& it = tasks_[task];
    TaskBound& entry = entries_[task];
    auto response = entry.free ? bound_of_free(task) : bound(task);
    if (entry.free && (!response || *response > it.period)) {
        entry.free = false;
        response = bound(task);
    }
    if (effort_.spent > limit_) effort_.exhausted = true;
    const WideTime most =
        std::min<WideTime>(kLongestBusyPeriod, (WideTime{it.period} + entry.job) * kMostPeriodsPerResponse);
    if (!response || *response > most || effort_.exhausted) return false;
    entry.response = std::max(entry.response, static_cast<Microseconds>(*response));
    return true;
}

/// Jobs of the level that start in a window before which none of them waited.
std::int64_t ParallelAnalysis::started(std::size_t task, Microseconds window) const {
    const Microseconds jitter = tasks_[task].jitter;
    return releases(task, window, entries_[task].free ? jitter : std::max(jitter, entries_[task].response));
}

WideTime ParallelAnalysis::largest(std::vector<WideTime>& parts) const {
    const auto most = std::min(parts.size(), static_cast<std::size_t>(slots_));
    std::ranges::partial_sort(parts, parts.begin() + static_cast<std::ptrdiff_t>(most), std::greater());
    return std::accumulate(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(most), WideTime{0});
}

/// For how long all slots can be busy, or held up, from t0 on, if it is not longer than w. Above w it is the
/// end of all times for which the same follows at once.
WideTime ParallelAnalysis::busy_of_free(std::size_t task, std::int64_t own, Microseconds w) const {
    WideTime held = 0;
    std::int64_t frames = slots_ + 1 + own;  // each may be followed by a pause
    std::vector<SlotWork> works{{.started = entries_[task].demand.most(own)}};
    works.front().with_carried = works.front().started;
    const bool one_by_one = waits_for_alone(task);
    for (const auto i : before_) {
        if (i == task) continue;
        const TaskBound& entry = entries_[i];
        const std::int64_t jobs = started(i, w);
        const std::int64_t all = std::max(jobs, active(i, w));
        frames += entry.frames * jobs;
        if (entry.alone) {
            held += held_up(i, all);
            continue;
        }
        if (one_by_one) {
            held += entry.demand.most(all);
            continue;
        }
        const WideTime started_work = entry.demand.most(jobs);
        const WideTime carried = started_work + entry.frame * WideTime{tasks_[i].burst};
        works.push_back({started_work, std::min(entry.demand.most(all), carried)});
    }
    for (const auto i : lower_) {
        if (entries_[i].alone)
            held += entries_[i].frame;
        else
            works.push_back({.started = 0, .with_carried = entries_[i].frame});
    }
    const WideTime idle = held + WideTime{frames} * connection_.pause;
    const WideTime busy = work_within(works, WideTime{w} + 1);
    const WideTime next = busy / slots_ + idle;
    // Up to the next limit of a work the sum is convex: where it fills the slots now, it does so until there.
    if (next <= w || work_within(works, WideTime{w} + 2) - busy < slots_) return next;
    return std::max(next, next_limit(works, WideTime{w} + 1) - 1);
}

/// What the tasks do in a time on the slots: what started in it, and the largest of what was in flight
/// before.
WideTime ParallelAnalysis::work_within(std::span<const SlotWork> works, WideTime time) const {
    effort_.spent += works.size();
    WideTime sum = 0;
    std::vector<WideTime> in_flight;
    for (const auto& [started, with_carried] : works) {
        sum += std::min(started, time);
        in_flight.push_back(std::min(with_carried, time) - std::min(started, time));
    }
    return sum + largest(in_flight);
}

/// The latest start of a job with `own` earlier ones since t0, counted from t0.
std::optional<WideTime> ParallelAnalysis::start_of_free(std::size_t task, std::int64_t own) const {
    for (Microseconds w = 0;;) {
        const WideTime next = busy_of_free(task, own, w);
        if (next <= w) return w;
        if (next > kLongestBusyPeriod || effort_.spent > limit_) return std::nullopt;
        w = static_cast<Microseconds>(next);
    }
}

// Each job of the busy period counts, as for one resource. The period ends where the demand of the level with
// all own jobs so far is done before the next one is released.
std::optional<WideTime> ParallelAnalysis::bound_of_free(std::size_t task) const {
    const Task& it = tasks_[task];
    WideTime longest = 0;
    auto start = start_of_free(task, 0);
    for (std::int64_t job = 0; start; ++job) {
        const WideTime nominal = WideTime{job} * it.period - it.jitter;
        longest = std::max(longest, std::max(*start, nominal + it.jitter) + entries_[task].job - nominal);
        start = start_of_free(task, job + 1);
        if (longest > it.period || (start && *start <= nominal + it.period)) return longest;
    }
    return std::nullopt;
}

ParallelAnalysis::LaneWait ParallelAnalysis::wait_for_lanes(std::size_t task) const {
    LaneWait wait;
    const Microseconds whole = entries_[task].response;
    const auto goes_before = [&](std::size_t other) {
        return tasks_[other].period > 0 && tasks_[other].priority <= tasks_[task].priority;
    };
    for (const auto number : entries_[task].lanes) {
        const Lane& lane = connection_.lanes[number];
        WideTime work = 0;
        Microseconds lower = 0;
        for (const auto i : lane.tasks) {
            if (i == task) continue;
            if (!goes_before(i)) {
                lower = std::max(lower, entries_[i].frame);
                continue;
            }
            work += entries_[i].demand.most(active(i, whole));
            wait.turns += WideTime{active(i, whole)} * entries_[i].frames;
        }
        effort_.spent += lane.tasks.size();
        wait.full += (work + lane.in_flight - 1) / lane.in_flight;
        wait.lower += lower;
    }
    if (!entries_[task].alone) return wait;
    for (const auto i : before_) {  // it starts when nothing is in flight
        if (i == task) continue;
        wait.full += entries_[i].demand.most(active(i, whole));
        wait.turns += WideTime{active(i, whole)} * entries_[i].frames;
    }
    wait.lower += longest_frame_;
    return wait;
}

/// For how long all slots are busy with others, or held up, during the response.
WideTime ParallelAnalysis::all_busy(std::size_t task, WideTime turns) const {
    const Microseconds whole = entries_[task].response;
    WideTime held = 0;
    std::int64_t frames = 0;
    std::vector<WideTime> works;
    const bool one_by_one = waits_for_alone(task);
    for (const auto i : before_) {
        if (i == task) continue;
        const std::int64_t jobs = active(i, whole);
        frames += jobs * entries_[i].frames;
        if (entries_[i].alone)
            held += held_up(i, jobs);
        else if (one_by_one)
            held += entries_[i].demand.most(jobs);
        else
            works.push_back(entries_[i].demand.most(jobs));
    }
    std::vector<WideTime> lower;
    for (const auto i : lower_) {
        if (entries_[i].alone)
            held += turns * entries_[i].frame;
        else
            lower.push_back(turns * entries_[i].frame);
    }
    const WideTime all_lower = largest(lower);
    // Concave in y, so the slots are busy without a break up to the first y that the sum does not fill.
    const auto busy_within = [&](WideTime y) {
        effort_.spent += works.size() + lower.size() + 1;
        WideTime sum = 0;
        for (const auto work : works) sum += std::min(work, y + 1);
        WideTime limited = 0;
        for (const auto work : lower) limited += std::min(work, y + 1);
        return (sum + std::min(limited, all_lower)) / slots_;
    };
    WideTime idle = busy_within(kLongestBusyPeriod);
    for (WideTime busy = 0; busy < idle && effort_.spent <= limit_;) {
        const WideTime middle = (busy + idle) / 2;
        if (busy_within(middle) <= middle)
            idle = middle;
        else
            busy = middle + 1;
    }
    return idle + held + (WideTime{frames} + turns * (slots_ + 1)) * connection_.pause;
}

// A failed attempt ends the share of its task, so that lower priorities may go before it again. Its time is
// not shared: where other tasks use one slot each for the whole time, one more unit of work in the last slot
// makes this time longer by one. Where a request goes alone, it waits again until nothing is in flight.
std::optional<WideTime> ParallelAnalysis::bound(std::size_t task) const {
    const Task& it = tasks_[task];
    const TaskBound& entry = entries_[task];
    const std::int64_t earlier = it.burst - 1 + entry.response / it.period;
    const LaneWait lanes = wait_for_lanes(task);
    const Microseconds failure_window = static_cast<Microseconds>(
        std::min<WideTime>(WideTime{entry.response} + longest_failure_, kLongestBusyPeriod));
    const WideTime failures = failures_.within(failure_window);
    const WideTime turns = WideTime{earlier + 1} * entry.frames + lanes.turns + failures;
    const WideTime again = has_alone_ ? longest_frame_ : 0;
    const WideTime failure = WideTime{longest_failure_} + again + connection_.pause;
    return it.jitter + entry.job + entry.demand.most(earlier) + all_busy(task, turns) + lanes.full +
           turns * lanes.lower + failures * failure +
           (turns + WideTime{earlier + 1} * entry.frames) * connection_.pause;
}

/// A device that does not answer: each job is `attempts` failures, at most once in each back-off.
std::vector<Task> with_dead_device(std::span<const Task> tasks, std::uint32_t device) {
    std::vector<Task> made(tasks.begin(), tasks.end());
    for (Task& task : made) {
        if (task.device != device) continue;
        task.shapes.clear();
        task.frames.assign(task.period == 0 ? 1 : std::max<std::uint32_t>(task.attempts, 1), task.failure);
        if (task.period > 0) task.period = std::max(task.period, task.backoff);
    }
    return made;
}

}  // namespace

Responses parallel_response_times(std::span<const Task> tasks, const Connection& connection, Effort* effort) {
    Effort own;
    const Failures none;
    return ParallelAnalysis(tasks, connection, none, effort ? *effort : own).run();
}

Responses parallel_response_times_with_faults(std::span<const Task> tasks, const Connection& connection,
                                              const FaultRate& faults, Effort* effort) {
    Effort own;
    const Failures failures(faults, 0);
    return ParallelAnalysis(tasks, connection, failures, effort ? *effort : own).run();
}

Responses parallel_response_times_with_dead_device(std::span<const Task> tasks, const Connection& connection,
                                                   Effort* effort) {
    Effort own;
    const Failures none;
    std::vector<std::uint32_t> devices;
    for (const Task& task : tasks) devices.push_back(task.device);
    std::ranges::sort(devices);
    devices.erase(std::ranges::unique(devices).begin(), devices.end());
    if (devices.size() < 2) return parallel_response_times(tasks, connection, effort);
    if (devices.size() * tasks.size() > kMostParallelDeadTasks) return Responses(tasks.size());
    Responses longest(tasks.size(), Microseconds{0});
    for (const auto device : devices) {
        const auto made = with_dead_device(tasks, device);
        const auto found = ParallelAnalysis(made, connection, none, effort ? *effort : own).run();
        for (std::size_t i = 0; i < tasks.size(); ++i) {
            if (tasks[i].device == device || !longest[i]) continue;
            longest[i] = found[i] ? std::optional(std::max(*longest[i], *found[i])) : std::nullopt;
        }
    }
    return longest;
}

}  // namespace takt::plan
