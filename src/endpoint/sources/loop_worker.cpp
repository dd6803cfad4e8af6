#include "takt/endpoint/loop_worker.hpp"

#include <chrono>
#include <mutex>
#include <utility>

namespace takt::endpoint {

// Shared with the jobs, because a job may outlive the LoopWorker. The mutex keeps the loop alive while a job
// posts to it.
struct LoopWorker::Results {
    std::mutex mutex;
    line::Loop* loop = nullptr;  // none: results are not wanted any more
    StopFlag stop{false};

    static void post(const std::shared_ptr<Results>& results, std::function<void()> result) {
        const std::lock_guard lock(results->mutex);
        if (results->loop == nullptr || !result) return;
        results->loop->post([results, result = std::move(result)] {
            if (!results->stop) result();
        });
    }
};

LoopWorker::LoopWorker(line::Loop& loop, std::size_t threads, std::size_t queue)
    : results_(std::make_shared<Results>()),
      worker_({.name = "takt-source",
               .threads = threads,
               .queue = queue,
               .at_end = os::Worker::AtEnd::discard,
               .join_timeout = std::chrono::seconds(1)}) {
    results_->loop = &loop;
}

LoopWorker::~LoopWorker() {
    const std::lock_guard lock(results_->mutex);
    results_->stop = true;
    results_->loop = nullptr;
}

bool LoopWorker::run(Job job) {
    return worker_.post(
        [results = results_, job = std::move(job)] { Results::post(results, job(results->stop)); });
}

}  // namespace takt::endpoint
