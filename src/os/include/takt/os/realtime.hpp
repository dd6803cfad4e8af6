// A thread that wakes up on time: its scheduling class, its processor, its memory.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace takt::os {

struct RealtimeOptions {
    std::optional<int> priority;  ///< of SCHED_FIFO, 1..99; nothing: only `cpu` counts
    std::optional<int> cpu;       ///< the processor of the thread, from 0; nothing: any
};

inline constexpr int kLeastPriority = 1;
inline constexpr int kMostPriority = 99;

/// In the order in which they are taken.
enum class RealtimeStep : std::uint8_t {
    lock_memory,  ///< no page of the process leaves memory: mlockall(2)
    keep_memory,  ///< the stack is present, and freed memory stays, except large blocks: mallopt(3)
    idle_states,  ///< processors do not enter slow idle states while the process lives: /dev/cpu_dma_latency
    processor,    ///< the thread runs on one processor: sched_setaffinity(2)
    timer_slack,  ///< its timers are not delayed to expire with others: prctl(2), PR_SET_TIMERSLACK
    scheduling,   ///< it runs before all threads of the normal class: sched_setscheduler(2), SCHED_FIFO
};

/// The word for JSON: "lock_memory" and so on.
[[nodiscard]] std::string_view name(RealtimeStep step);

struct RealtimeResult {
    RealtimeStep step{};
    int error = 0;  ///< errno; 0: done
};

/// Takes the steps that the options ask for, for the calling thread: with a priority all but `processor`,
/// with a processor `processor`. A step that fails does not prevent the others. Threads that the calling
/// thread starts later have normal scheduling; they share its processor. Several threads may call it, but not
/// at the same time: the steps for the process are taken again.
/// @returns each step that was tried
[[nodiscard]] std::vector<RealtimeResult> become_realtime(const RealtimeOptions& options);

}  // namespace takt::os
