// The inside of the event loop, shared by its three parts: loop.cpp, timer.cpp, watch.cpp.
#pragma once

#include <sys/epoll.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "signal_pipe.hpp"
#include "takt/line/loop.hpp"
#include "takt/os/descriptor.hpp"
#include "takt/os/worker.hpp"

namespace takt::line {

/// The timers that are set: a binary heap by the moment each was last known to be due. One that was moved to
/// later since stays where it is until that moment comes.
class TimerQueue {
public:
    void update(Timer& timer);
    void remove(Timer& timer);
    /// When there may be something to do; kNever: nothing is set.
    [[nodiscard]] Instant next() const { return heap_.empty() ? kNever : heap_.front().key; }
    /// Takes out the first timer that is due at `t`; nullptr: none is.
    Timer* take_due(Instant t);
    [[nodiscard]] std::size_t size() const { return heap_.size(); }

private:
    struct Entry {
        Instant key;
        Timer* timer = nullptr;
    };
    void put(std::size_t place, Entry entry);
    void sift_up(std::size_t place);
    void sift_down(std::size_t place);

    std::vector<Entry> heap_;
};

/// One turn of the loop: the events of one look at the descriptors, then the timers that were due by then,
/// then the tasks that were posted by then; so none of them holds up the others.
struct Loop::Impl {
    enum class Phase : std::uint8_t { events, timers, tasks, done };
    static constexpr std::size_t kEvents = 64;

    os::Descriptor epoll;
    os::Descriptor alarm;  // a timerfd: to the microsecond, without the slack of a time-out
    os::Descriptor bell;   // an eventfd: rung by other threads
    Instant alarm_at = kNever;
    std::array<epoll_event, kEvents> events{};
    std::size_t event_count = 0;
    std::size_t event_next = 0;
    Phase phase = Phase::done;
    Instant phase_time;
    std::size_t phase_left = 0;
    TimerQueue timers;
    std::deque<Watch*> ready;    // regular files that were asked for
    std::size_t ready_left = 0;  // of these, in this turn
    void* calling = nullptr;     // the timer or watch whose callback runs; nullptr once it is destroyed
    std::atomic<bool> stopped = false;
    std::mutex mutex;
    std::deque<std::function<void()>> tasks;  // guarded by mutex
    std::optional<SignalPipe> signals;
    std::unique_ptr<Watch> signal_watch;

    std::unique_ptr<os::Worker> lookups;  // of Resolvers; none before the first

    Result<void> open();
    /// Enqueues a name look-up. The job may outlive the loop. @returns false when there are too many
    bool look_up(os::Worker::Job job);
    void ring() const;
    /// Calls one callback. @returns false when `end` came first
    bool run_one(Instant end);
    void forget(const Watch& watch);

private:
    void wait(Instant end);
    void set_alarm(Instant when);
    bool run_event();
    bool run_timer();
    bool run_task();
};

}  // namespace takt::line
