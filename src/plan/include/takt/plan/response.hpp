// Worst-case response times of one line under non-preemptive scheduling (docs/guarantees.md).
// Sources: George, Rivierre, Spuri 1996; Davis, Burns, Bril, Lukkien 2007; Jeffay, Stanat, Martel 1991.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace takt::plan {

/// Whole microseconds. C and F are rounded up; everything computed from them is exact.
using Microseconds = std::int64_t;

/// One task: a request as the analysis sees it. Times are between zero and a year.
struct Task {
    /// C of each frame of one job, in order. A more urgent task may be sent between two frames.
    std::vector<Microseconds> frames;
    /// Shapes: the frames of consecutive jobs, cyclic, if their demand differs; a release may send nothing.
    /// Empty: every job is `frames`. The demand of n jobs is that of the costliest n consecutive ones.
    std::vector<std::vector<Microseconds>> shapes;
    Microseconds failure = 0;   ///< F: the cost of one failed attempt
    Microseconds period = 0;    ///< T, or the least time between two commands; 0: no bound of its own
    Microseconds deadline = 0;  ///< D
    Microseconds jitter = 0;    ///< J
    std::uint32_t burst = 1;    ///< b, at least 1
    /// A lower number is more urgent; tasks with the same number are equal. A task with period 0 only blocks.
    std::uint32_t priority = 0;
    std::uint32_t device = 0;    ///< tasks of one device die together
    std::uint32_t attempts = 1;  ///< transmissions before its device counts as dead
    Microseconds backoff = 0;    ///< least time between two attempts at a dead device
    /// After each failed attempt the next one waits this long, because a late answer may come. The line is
    /// free meanwhile.
    Microseconds late = 0;
};

/// E(t) = burst + floor(t / every): the limit of failed attempts in any window t.
struct FaultRate {
    std::uint32_t burst = 1;
    Microseconds every = 1'000'000;  ///< above 0
};

/// A longer busy period counts as unbounded: 366 days.
inline constexpr Microseconds kLongestBusyPeriod = Microseconds{366} * 24 * 3600 * 1'000'000;

/// Longest response of each task, from the nominal release to the end of the last frame. Nothing: unbounded
/// (the load of this and all more or equally urgent tasks exceeds the line, or period 0).
using Responses = std::vector<std::optional<Microseconds>>;

/// The work of analyses, in divisions. One iteration step costs as many as there are distinct pairs of period
/// and jitter.
struct Effort {
    /// Limit of one analysis, about. Beyond it the remaining tasks get the bound by rates, which is larger.
    std::uint64_t most = 100'000'000;
    std::uint64_t spent = 0;  ///< by this analysis and earlier ones
    bool exhausted = false;   ///< an analysis reached its limit: some bounds are larger than exact ones
};

/// Fixed priority, without failures. Exact: every job of the busy period is examined.
/// @param effort  nullptr: Effort()
[[nodiscard]] Responses response_times(std::span<const Task> tasks, Effort* effort = nullptr);

/// With failed attempts. Each one returns to the queue with its priority.
[[nodiscard]] Responses response_times_with_faults(std::span<const Task> tasks, const FaultRate& faults,
                                                   Effort* effort = nullptr);

/// With the worst single dead device: the longest response over each other device being dead. Each task of
/// the dead device is a job of `attempts` failures every max(period, back-off). Without other devices like
/// response_times().
[[nodiscard]] Responses response_times_with_dead_device(std::span<const Task> tasks,
                                                        Effort* effort = nullptr);

/// Earliest deadline first: whether all deadlines are met, with `faults` if given. Tasks with period 0 only
/// block. Also false if more than 2 * 10^6 deadlines would have to be examined.
[[nodiscard]] bool feasible_edf(std::span<const Task> tasks, const std::optional<FaultRate>& faults = {});

/// Sum of C / T. Above 1, all tasks as urgent as the one that exceeds it, or less urgent, are unbounded.
[[nodiscard]] double utilization(std::span<const Task> tasks);

}  // namespace takt::plan
