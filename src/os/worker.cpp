// The queue is a binary heap ordered by due time, then by sequence number. An immediate job is due at the
// time it was posted, so the heap yields immediate jobs first in, first out. The heap's storage is reserved
// once.
#include "takt/os/worker.hpp"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "takt/os/thread_name.hpp"

namespace takt::os {

// Shared with the threads, because a detached thread may outlive the worker.
struct Worker::State {
    struct Entry {
        Clock::time_point due;
        std::uint64_t sequence = 0;
        Job job;
    };
    static bool later(const Entry& a, const Entry& b) {
        return std::pair(a.due, a.sequence) > std::pair(b.due, b.sequence);
    }

    std::mutex mutex;
    std::condition_variable changed;  // a job, the end, or the end of a thread
    std::vector<Entry> queue;         // a heap by later()
    std::uint64_t next_sequence = 0;
    std::size_t idle = 0;     // threads that run no job
    std::size_t running = 0;  // threads that have not ended
    bool ending = false;
    std::vector<std::thread> threads;  // the owner's
    const char* name = nullptr;

    void start(const std::shared_ptr<State>& self) {
        threads.emplace_back([self] { self->work(); });
        ++idle;
        ++running;
    }

    void work() {
        name_thread(name);
        std::unique_lock lock(mutex);
        while (!(ending && queue.empty())) {
            if (queue.empty()) {
                changed.wait(lock);
                continue;
            }
            if (const auto due = queue.front().due; !ending && due > Clock::now()) {
                changed.wait_until(lock, due);
                continue;
            }
            std::ranges::pop_heap(queue, later);
            Job job = std::move(queue.back().job);
            queue.pop_back();
            --idle;
            lock.unlock();
            job();
            job = nullptr;
            lock.lock();
            ++idle;
        }
        --running;
        changed.notify_all();
    }
};

Worker::Worker(const Options& options) : options_(options), state_(std::make_shared<State>()) {
    state_->queue.reserve(options_.queue);
    state_->name = options_.name;
    state_->threads.reserve(options_.threads);
    const std::lock_guard lock(state_->mutex);
    state_->start(state_);
}

Worker::~Worker() {
    finish();
}

bool Worker::post_at(Clock::time_point when, Job job) {
    State& state = *state_;
    const std::lock_guard lock(state.mutex);
    if (state.ending || state.queue.size() >= options_.queue) return false;
    state.queue.push_back({when, state.next_sequence++, std::move(job)});
    std::ranges::push_heap(state.queue, State::later);
    if (state.idle < state.queue.size() && state.threads.size() < options_.threads) {
        try {
            state.start(state_);
        } catch (const std::system_error&) {  // NOLINT(bugprone-empty-catch): running threads take the job
        }
    }
    state.changed.notify_one();
    return true;
}

void Worker::finish() {
    State& state = *state_;
    std::vector<std::thread> threads;
    {
        std::vector<State::Entry> discarded;  // destroyed without the lock: a job may own anything
        const std::lock_guard lock(state.mutex);
        state.ending = true;
        threads.swap(state.threads);
        if (options_.at_end == AtEnd::discard) discarded.swap(state.queue);
        state.changed.notify_all();
    }
    bool all_ended = true;
    if (options_.join_timeout) {
        std::unique_lock lock(state.mutex);
        all_ended =
            state.changed.wait_for(lock, *options_.join_timeout, [&state] { return state.running == 0; });
    }
    for (auto& thread : threads)
        if (all_ended)
            thread.join();
        else
            thread.detach();
}

}  // namespace takt::os
