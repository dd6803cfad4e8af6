// A binary heap of timers by key. The key is a lower bound of the timer's instant: a timer that is moved to a
// later instant, or cancelled, keeps its entry until the key is due; only then it sinks to its new position
// or is removed. So a deadline that each byte postpones costs nothing. Each timer knows its index in the
// heap.
#include <utility>

#include "loop/loop_impl.hpp"

namespace takt::line {

Timer::Timer(Loop& loop, std::function<void(Instant)> callback)
    : loop_(loop.impl()), callback_(std::move(callback)) {}

Timer::~Timer() {
    loop_.timers.remove(*this);
    if (loop_.calling == this) loop_.calling = nullptr;
}

void Timer::set(Instant when) {
    if (when == when_) return;
    when_ = when;
    loop_.timers.update(*this);
}

// The callback may destroy the timer, so it is moved out of the timer while it runs.
void Timer::expire(Instant t) {
    when_ = kNever;
    Loop::Impl& loop = loop_;
    void* const outer = std::exchange(loop.calling, this);
    auto callback = std::move(callback_);
    callback(t);
    if (loop.calling == this) callback_ = std::move(callback);
    loop.calling = outer;
}

void TimerQueue::update(Timer& timer) {
    if (timer.index_ == Timer::kNowhere) {
        if (timer.when_ == kNever) return;
        heap_.emplace_back();
        put(heap_.size() - 1, {timer.when_, &timer});
        sift_up(heap_.size() - 1);
    } else if (timer.when_ < heap_[timer.index_].key) {
        heap_[timer.index_].key = timer.when_;
        sift_up(timer.index_);
    }
}

void TimerQueue::remove(Timer& timer) {
    const std::size_t place = timer.index_;
    if (place == Timer::kNowhere) return;
    timer.index_ = Timer::kNowhere;
    const Entry last = heap_.back();
    heap_.pop_back();
    if (place == heap_.size()) return;
    put(place, last);
    sift_up(place);
    sift_down(last.timer->index_);
}

Timer* TimerQueue::take_due(Instant t) {
    while (!heap_.empty() && heap_.front().key <= t) {
        Timer& first = *heap_.front().timer;
        if (first.when_ == kNever) {
            remove(first);
        } else if (first.when_ > heap_.front().key) {
            heap_.front().key = first.when_;
            sift_down(0);
        } else {
            remove(first);
            return &first;
        }
    }
    return nullptr;
}

void TimerQueue::put(std::size_t place, Entry entry) {
    heap_[place] = entry;
    entry.timer->index_ = place;
}

void TimerQueue::sift_up(std::size_t place) {
    const Entry entry = heap_[place];
    for (; place > 0; place = (place - 1) / 2) {
        const Entry& above = heap_[(place - 1) / 2];
        if (above.key <= entry.key) break;
        put(place, above);
    }
    put(place, entry);
}

void TimerQueue::sift_down(std::size_t place) {
    const Entry entry = heap_[place];
    for (;;) {
        std::size_t below = 2 * place + 1;
        if (below >= heap_.size()) break;
        if (below + 1 < heap_.size() && heap_[below + 1].key < heap_[below].key) ++below;
        if (entry.key <= heap_[below].key) break;
        put(place, heap_[below]);
        place = below;
    }
    put(place, entry);
}

}  // namespace takt::line
