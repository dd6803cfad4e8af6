// Internals of the event loop, shared by loop.cpp, timer.cpp and watch.cpp.
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

#include "loop/arrival_forecast.hpp"
#include "loop/signal_pipe.hpp"
#include "takt/line/loop.hpp"
#include "takt/os/descriptor.hpp"
#include "takt/os/worker.hpp"

namespace takt::line {

/// The set timers: a binary heap by due time. A timer moved to a later instant keeps its old key until that
/// key expires (lazy update).
class TimerQueue {
public:
    void update(Timer& timer);
    void remove(Timer& timer);
    /// The least key of the heap; kNever: no timer is set. The timer itself may be due later.
    [[nodiscard]] Instant next() const { return heap_.empty() ? kNever : heap_.front().key; }
    /// Removes the first timer that is due at `t`; nullptr: none.
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

/// One round: the pending descriptor events, then the timers due by then, then the tasks posted by then. No
/// phase can starve the others.
struct Loop::Impl {
    enum class Phase : std::uint8_t { events, timers, tasks, done };
    static constexpr std::size_t kEvents = 64;

    os::Descriptor epoll;
    os::Descriptor alarm;  // a timerfd: to the microsecond, without the slack of a time-out
    os::Descriptor bell;   // an eventfd: rung by other threads
    Instant alarm_at = kNever;
    Duration spin{};                          // of polling before each sleep, and around the expected event
    std::optional<ArrivalForecast> forecast;  // if the loop spins
    std::array<epoll_event, kEvents> events{};
    std::size_t event_count = 0;
    std::size_t event_next = 0;
    Phase phase = Phase::done;
    Instant phase_time;
    std::size_t phase_left = 0;
    TimerQueue timers;
    std::deque<Watch*> ready;    // requested regular files
    std::size_t ready_left = 0;  // of these, in this round
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
    /// Calls one callback. @returns false if `end` came first
    bool run_one(Instant end);
    void forget(const Watch& watch);

private:
    void wait(Instant end);
    [[nodiscard]] int poll_events(int timeout_ms);
    [[nodiscard]] int spin_until(Instant until);
    [[nodiscard]] Instant spin_end() const;
    [[nodiscard]] Instant spin_again() const;
    void note_arrival();
    void set_alarm(Instant when);
    bool run_event();
    bool run_timer();
    bool run_task();
};

}  // namespace takt::line
