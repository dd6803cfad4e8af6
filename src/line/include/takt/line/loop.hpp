// The event loop of the I/O thread, and the two clocks of the program's edge.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"

namespace takt::line {

/// The engines' time: std::chrono::steady_clock in nanoseconds. Any thread.
[[nodiscard]] Instant now();

/// The wall-clock time of `t`, for log stamps. It follows adjustments of the system clock. Any thread.
[[nodiscard]] std::chrono::system_clock::time_point wall_clock(Instant t);

/// Usual lateness of a timer on an idle machine.
inline constexpr Duration kTimerLateness = std::chrono::microseconds(80);

/// Waits for descriptors, timers, signals and posted tasks, and calls back on the thread that runs it.
///
/// The loop must outlive every Timer, Watch, driver and server made with it. These are made, used and
/// destroyed on the thread that runs the loop, or while no thread runs it. Callbacks must not throw.
class Loop {
public:
    /// @returns io_failed with errno if no descriptors are left
    [[nodiscard]] static Result<std::unique_ptr<Loop>> create();
    ~Loop();
    Loop(const Loop&) = delete;
    Loop& operator=(const Loop&) = delete;

    /// Runs until stop(). A stopped loop stays stopped.
    void run();

    /// Runs until `done()` is true (evaluated after every callback), stop() is called, or `limit` has passed.
    /// @returns done()
    bool run_until(const std::function<bool()>& done, Duration limit);

    /// Before the loop sleeps, it polls its descriptors for this long, which saves the time of waking up and
    /// takes the processor. If the events come in a steady cycle, it also polls around the instant of the
    /// next one, until that is late by as much. To be called before run(), or from a callback.
    void set_spin(Duration spin);

    /// Makes run() and run_until() return after the callback in progress. Any thread.
    void stop();
    [[nodiscard]] bool stopped() const;

    /// Calls `task` on the loop's thread, in the order of posting. Any thread.
    void post(std::function<void()> task);

    /// Calls back with the number of each given signal (SIGINT, SIGTERM, ...) instead of its default action.
    /// A second call replaces the first.
    [[nodiscard]] Result<void> on_signals(std::initializer_list<int> signals,
                                          std::function<void(int)> callback);

    struct Impl;
    [[nodiscard]] Impl& impl() { return *impl_; }

private:
    explicit Loop(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

/// Calls back once, at the set instant or slightly later, never earlier. The callback may set the timer again
/// or destroy it. Moving a timer to a later instant costs no system call.
class Timer {
public:
    Timer(Loop& loop, std::function<void(Instant)> callback);
    ~Timer();
    Timer(const Timer&) = delete;
    Timer& operator=(const Timer&) = delete;

    /// Sets, moves or (kNever) cancels the timer. A past instant means as soon as possible.
    void set(Instant when);
    [[nodiscard]] Instant when() const { return when_; }

private:
    friend class TimerQueue;
    friend struct Loop::Impl;
    static constexpr std::size_t kNowhere = SIZE_MAX;

    void expire(Instant t);

    Loop::Impl& loop_;
    std::function<void(Instant)> callback_;
    Instant when_ = kNever;
    std::size_t index_ = kNowhere;  // index in the loop's heap
};

/// Calls back when a descriptor is readable or writable, or has an error. The owner keeps the descriptor open
/// while the watch exists; a descriptor has at most one watch. The callbacks may destroy the watch. A
/// blocking descriptor (standard input) stays blocking. A regular file cannot be waited for and is always
/// ready.
class Watch {
public:
    Watch(Loop& loop, int fd, std::function<void()> readable, std::function<void()> writable = {});
    ~Watch();
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

    /// False if the system refused to watch the descriptor; want_read() and want_write() then do nothing.
    [[nodiscard]] bool ok() const { return state_ != State::refused; }

    /// Requests one call of `readable` (`writable`). A repeated request has no effect.
    void want_read();
    void want_write();
    /// Requests one call of `readable` when the peer has closed both directions, or at an error.
    void want_hang_up();

private:
    friend struct Loop::Impl;
    enum class State : std::uint8_t { watched, left_out, always_ready, refused };

    void want(std::uint32_t events);
    void act(std::uint32_t events);
    bool call(std::function<void()> Watch::* callback);
    void update_epoll();

    Loop::Impl& loop_;
    int fd_;
    State state_ = State::watched;
    std::uint32_t wanted_ = 0;   // events requested by the owner
    std::uint32_t watched_ = 0;  // events registered with epoll
    std::function<void()> readable_;
    std::function<void()> writable_;
};

}  // namespace takt::line
