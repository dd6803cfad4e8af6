#include "evaluation_queue.hpp"

#include <utility>

namespace takt::web {

EvaluationQueue::Turn::Turn(EvaluationQueue& queue, std::string client)
    : queue_(queue), client_(std::move(client)) {
    const std::scoped_lock lock(queue_.mutex_);
    auto& mine = queue_.clients_[client_];
    mine.newest = number_ = ++queue_.numbers_;
    ++mine.turns;
    queue_.changed_.notify_all();
}

EvaluationQueue::Turn::~Turn() {
    const std::scoped_lock lock(queue_.mutex_);
    if (begun_) --queue_.in_progress_;
    const auto mine = queue_.clients_.find(client_);
    if (--mine->second.turns == 0) queue_.clients_.erase(mine);
    queue_.changed_.notify_all();
}

bool EvaluationQueue::Turn::is_superseded() const {
    return queue_.clients_.find(client_)->second.newest != number_;
}

bool EvaluationQueue::Turn::begin() {
    std::unique_lock lock(queue_.mutex_);
    queue_.changed_.wait(lock, [this] { return is_superseded() || queue_.in_progress_ < queue_.most_; });
    if (is_superseded()) return false;
    begun_ = true;
    ++queue_.in_progress_;
    return true;
}

bool EvaluationQueue::Turn::superseded() const {
    const std::scoped_lock lock(queue_.mutex_);
    return is_superseded();
}

}  // namespace takt::web
