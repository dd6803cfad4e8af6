#include "takt/source/worker.hpp"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

namespace takt::source {
namespace {

using Job = std::function<std::function<void()>(const StopFlag&)>;

}  // namespace

struct Worker::Shared {
    std::mutex mutex;
    std::condition_variable changed;
    std::deque<Job> jobs;
    std::size_t room = 0;
    std::size_t threads = 0;  // running threads
    StopFlag stop{false};
    line::Loop* loop = nullptr;  // null: results are dropped

    void work(const std::shared_ptr<Shared>& self) {
        std::unique_lock lock(mutex);
        while (true) {
            changed.wait(lock, [this] { return stop || !jobs.empty(); });
            if (stop) break;
            const Job job = std::move(jobs.front());
            jobs.pop_front();
            lock.unlock();
            auto result = job(stop);
            lock.lock();
            if (loop != nullptr && result)
                loop->post([self, result = std::move(result)] {
                    if (!self->stop) result();
                });
        }
        --threads;
        changed.notify_all();
    }
};

Worker::Worker(line::Loop& loop, std::size_t threads, std::size_t room)
    : shared_(std::make_shared<Shared>()) {
    shared_->room = room;
    shared_->threads = threads;
    shared_->loop = &loop;
    // Detached: a thread that hangs in an unreachable file system must not keep the program from ending.
    for (std::size_t i = 0; i < threads; ++i)
        std::thread([shared = shared_] { shared->work(shared); }).detach();
}

Worker::~Worker() {
    std::unique_lock lock(shared_->mutex);
    shared_->stop = true;
    shared_->loop = nullptr;
    shared_->jobs.clear();
    shared_->changed.notify_all();
    shared_->changed.wait_for(lock, std::chrono::seconds(1), [this] { return shared_->threads == 0; });
}

bool Worker::run(Job job) {
    const std::lock_guard lock(shared_->mutex);
    if (shared_->jobs.size() >= shared_->room) return false;
    shared_->jobs.push_back(std::move(job));
    shared_->changed.notify_one();
    return true;
}

}  // namespace takt::source
