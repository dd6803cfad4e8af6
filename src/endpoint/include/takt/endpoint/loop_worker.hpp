// Blocking work beside a loop: files, commands.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>

#include "takt/line/loop.hpp"
#include "takt/os/worker.hpp"

namespace takt::endpoint {

/// Passed to jobs: true once their results are not wanted any more.
using StopFlag = std::atomic<bool>;

/// Runs blocking jobs on an os::Worker and hands their results to a loop. The loop's thread only; the loop
/// outlives it.
class LoopWorker {
public:
    /// Does the blocking work and returns what is to be done with its result. The result is called on the
    /// loop's thread, and never after the LoopWorker was destroyed.
    using Job = std::function<std::function<void()>(const StopFlag& stop)>;

    /// @param threads  1..16
    /// @param queue    jobs that may wait for a thread
    LoopWorker(line::Loop& loop, std::size_t threads, std::size_t queue);
    /// Discards waiting jobs. Jobs at work get up to a second to see the flag; then their threads are
    /// detached, because a file system that does not answer must not keep the program from ending.
    ~LoopWorker();
    LoopWorker(const LoopWorker&) = delete;
    LoopWorker& operator=(const LoopWorker&) = delete;

    /// @returns false when the queue is full
    bool run(Job job);

private:
    struct Results;
    std::shared_ptr<Results> results_;
    os::Worker worker_;
};

}  // namespace takt::endpoint
