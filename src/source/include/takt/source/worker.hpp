// Threads for blocking calls: files, commands.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>

#include "takt/line/loop.hpp"

namespace takt::source {

/// Passed to jobs: true once their results are no longer needed.
using StopFlag = std::atomic<bool>;

/// Runs jobs on a few threads, first come, first served, and delivers their results on the loop's thread. All
/// calls on the loop's thread; the loop outlives the worker.
class Worker {
public:
    /// @param threads  1..16
    /// @param room     limit of waiting jobs
    Worker(line::Loop& loop, std::size_t threads, std::size_t room);
    /// Waiting jobs are dropped. Running ones get up to a second to notice the flag, then they are abandoned.
    ~Worker();
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    /// @param job  called on some thread. The function it returns is called on the loop's thread, unless the
    /// worker
    ///             has been destroyed
    /// @returns false if the queue is full
    bool run(std::function<std::function<void()>(const StopFlag& stop)> job);

private:
    struct Shared;
    std::shared_ptr<Shared> shared_;
};

}  // namespace takt::source
