// A thread (or a few) for work that may block, behind a bounded queue.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

namespace takt::os {

/// Runs jobs on threads of its own.
///
/// With one thread the jobs run one after another in the order of post(). With several threads they start in
/// that order. A job that is posted for a later time starts then at the earliest.
///
/// post() and post_at() may be called from any thread, also from a job. They never wait for a job and, for a
/// callable of up to three pointers, never allocate. A job must not throw. finish() and the destructor are
/// for the owner's thread and must not be called from a job.
class Worker {
public:
    using Clock = std::chrono::steady_clock;
    using Job = std::move_only_function<void()>;

    /// The treatment of jobs that have not started at the end.
    enum class AtEnd : std::uint8_t {
        drain,    ///< they run, those for a later time at once
        discard,  ///< they are destroyed without running
    };

    struct Options {
        const char* name = "takt-worker";  ///< of its threads (name_thread())
        std::size_t threads = 1;           ///< at most; all but the first start when they are needed
        std::size_t queue = 64;            ///< jobs that wait, at most
        AtEnd at_end = AtEnd::drain;
        /// How long the end waits for jobs at work; threads that take longer are detached and end after their
        /// job. A job must then own all that it uses. None: the end waits for all threads.
        std::optional<std::chrono::milliseconds> join_timeout;
    };

    /// One thread, 64 jobs, drained and joined at the end.
    Worker() : Worker(Options{}) {}
    /// @throws std::system_error when the first thread cannot be started
    explicit Worker(const Options& options);
    /// finish()
    ~Worker();
    Worker(const Worker&) = delete;
    Worker& operator=(const Worker&) = delete;

    /// Enqueues a job. @returns false when the queue is full or the end has begun; the job is destroyed
    bool post(Job job) { return post_at(Clock::now(), std::move(job)); }

    /// Enqueues a job that does not start before `when`.
    bool post_at(Clock::time_point when, Job job);

    /// Rejects further jobs, drains or discards the queue and ends the threads. A second call does nothing.
    void finish();

private:
    struct State;

    Options options_;
    std::shared_ptr<State> state_;
};

}  // namespace takt::os
