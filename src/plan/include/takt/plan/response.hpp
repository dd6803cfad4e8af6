// How long a request can take in the worst case: non-preemptive scheduling of one line (guarantees).
// Sources: George, Rivierre, Spuri 1996; Davis, Burns, Bril, Lukkien 2007; Jeffay, Stanat, Martel 1991.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace takt::plan {

/// Whole microseconds. C and F are rounded up to them; all that follows is exact.
using Microseconds = std::int64_t;

/// One request of a line as the analysis sees it. Times are neither negative nor above a year.
struct Task {
    /// C of each frame of one job, in the order they are sent; a more urgent task may go between two frames.
    std::vector<Microseconds> frames;
    /// Jobs whose demand differs from release to release (shapes): the frames of each in turn, cyclic; a
    /// release may send nothing. Empty: each is `frames`. The demand of n jobs is then that of the costliest
    /// n in a row.
    std::vector<std::vector<Microseconds>> shapes;
    Microseconds failure = 0;   ///< F: the cost of one failed attempt
    Microseconds period = 0;    ///< T, or the least time between two commands; 0: no bound of its own
    Microseconds deadline = 0;  ///< D
    Microseconds jitter = 0;    ///< J
    std::uint32_t burst = 1;    ///< b, at least 1
    /// Less is more urgent; tasks with the same number are equals. A task with period 0 only blocks.
    std::uint32_t priority = 0;
    std::uint32_t device = 0;    ///< who dies together
    std::uint32_t attempts = 1;  ///< transmissions before its device counts as dead
    Microseconds backoff = 0;    ///< least time between two attempts at a dead device
    /// After each failed attempt the next one is held back for so long, for fear of a late answer; the line
    /// is free meanwhile.
    Microseconds late = 0;
};

/// E(t) = burst + floor(t / every): the most attempts that fail in any window t.
struct FaultRate {
    std::uint32_t burst = 1;
    Microseconds every = 1'000'000;  ///< above 0
};

/// A busy period beyond this counts as endless: 366 days.
inline constexpr Microseconds kLongestBusyPeriod = Microseconds{366} * 24 * 3600 * 1'000'000;

/// Longest response times in the order of the tasks, from the nominal release to the end of the last frame.
/// Nothing: unbounded (its own load and that of what is as urgent or more exceeds the line, or period 0).
using Responses = std::vector<std::optional<Microseconds>>;

/// Fixed priority, without failures. Exact, by every job of the busy period. A step of an iteration costs as
/// many divisions as there are distinct pairs of period and jitter; where more than about 10^8 of them would
/// be needed, the rest gets a bound by the line's rates, which is above the exact one.
[[nodiscard]] Responses response_times(std::span<const Task> tasks);

/// With failed attempts; each goes back into the queue with its priority.
[[nodiscard]] Responses response_times_with_faults(std::span<const Task> tasks, const FaultRate& faults);

/// With the worst single dead device: for each task the longest over every other device dead, each dead task
/// a job of `attempts` failures every max(period, back-off). Without other devices as response_times().
[[nodiscard]] Responses response_times_with_dead_device(std::span<const Task> tasks);

/// Earliest deadline first: whether all deadlines hold, with `faults` where given. Tasks with period 0 only
/// block. False also where more than 2 * 10^6 deadlines would have to be looked at.
[[nodiscard]] bool feasible_edf(std::span<const Task> tasks, const std::optional<FaultRate>& faults = {});

/// The exact test of Jeffay, Stanat and Martel for sporadic tasks of one frame with D = T, without jitter,
/// bursts and shapes; nothing for others.
[[nodiscard]] std::optional<bool> feasible_edf_sporadic(std::span<const Task> tasks);

/// Sum of C / T; above 1 nothing is bounded that is as urgent as what exceeds it, or less.
[[nodiscard]] double utilization(std::span<const Task> tasks);

}  // namespace takt::plan
