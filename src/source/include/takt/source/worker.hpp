// Threads for what may block: files, commands.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>

#include "takt/line/loop.hpp"

namespace takt::source {

/// Told to jobs: true once nobody wants their results any more.
using StopFlag = std::atomic<bool>;

/// Runs jobs on a few threads, first come, first served, and hands back on the loop's thread what to do with
/// their results. The loop's thread only; the loop outlives it.
class Worker {
public:
    /// @param threads  1..16
    /// @param room     jobs that may wait for a thread
    Worker(line::Loop& loop, std::size_t threads, std::size_t room);
    /// Jobs that wait are dropped; those at work get up to a second to see the flag, then they are left
    /// alone.
    ~Worker();
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    /// @param job  called on some thread; what it returns is called on the loop's thread, but never once the
    ///             worker is gone
    /// @returns false when there is no room
    bool run(std::function<std::function<void()>(const StopFlag& stop)> job);

private:
    struct Shared;
    std::shared_ptr<Shared> shared_;
};

}  // namespace takt::source
