// The event loop of the I/O thread, and the two clocks at the edge of the program.
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

/// The engines' time: std::chrono::steady_clock, nanosecond for nanosecond. Any thread.
[[nodiscard]] Instant now();

/// The wall-clock time that belongs to `t`, for log stamps; it follows a clock that is set. Any thread.
[[nodiscard]] std::chrono::system_clock::time_point wall_clock(Instant t);

/// Waits for descriptors, timers, signals and posted tasks, and calls back; everything on the one thread
/// that runs it.
///
/// The loop must outlive every Timer, Watch, driver and server made with it, and these are made, used and
/// destroyed on the thread that runs it (or while none does). Callbacks must not throw.
class Loop {
public:
    /// @returns io_failed with the system's error number when there are no descriptors left
    [[nodiscard]] static Result<std::unique_ptr<Loop>> create();
    ~Loop();
    Loop(const Loop&) = delete;
    Loop& operator=(const Loop&) = delete;

    /// Works until stop(). A stopped loop stays stopped.
    void run();

    /// Works until `done()`, asked after every callback, or stop(), or for `limit`.
    /// @returns done()
    bool run_until(const std::function<bool()>& done, Duration limit);

    /// Makes run() and run_until() return after the callback in progress. Any thread.
    void stop();
    [[nodiscard]] bool stopped() const;

    /// Calls `task` on the loop's thread, in the order of posting. Any thread.
    void post(std::function<void()> task);

    /// Calls back with the number of each of the given signals (SIGINT, SIGTERM, ...) instead of what they
    /// do by default. A second call replaces the first.
    [[nodiscard]] Result<void> on_signals(std::initializer_list<int> signals,
                                          std::function<void(int)> callback);

    struct Impl;
    [[nodiscard]] Impl& impl() { return *impl_; }

private:
    explicit Loop(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

/// Calls back once at a set moment or a little later, never earlier. The callback may set it anew or
/// destroy it. Moving it to later costs nothing.
class Timer {
public:
    Timer(Loop& loop, std::function<void(Instant)> callback);
    ~Timer();
    Timer(const Timer&) = delete;
    Timer& operator=(const Timer&) = delete;

    /// Sets, moves or (kNever) cancels it. A moment that has passed: as soon as possible.
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
    std::size_t place_ = kNowhere;  // in the loop's queue
};

/// Calls back when a descriptor can be read or written, or has an error to tell. The descriptor stays its
/// owner's and must be open as long as the watch is there; one watch a descriptor. The callbacks may destroy
/// the watch. A blocking descriptor (standard input) stays blocking. A regular file, which cannot be waited
/// for, is always ready.
class Watch {
public:
    Watch(Loop& loop, int fd, std::function<void()> readable, std::function<void()> writable = {});
    ~Watch();
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

    /// False when the system refused to watch the descriptor; want_… then does nothing.
    [[nodiscard]] bool ok() const { return state_ != State::refused; }

    /// Asks for one call of `readable` (`writable`); harmless when it was asked for already.
    void want_read();
    void want_write();

private:
    friend struct Loop::Impl;
    enum class State : std::uint8_t { watched, left_out, always_ready, refused };

    void want(std::uint32_t events);
    void act(std::uint32_t events);
    bool call(std::function<void()> Watch::* callback);
    void tell_system();

    Loop::Impl& loop_;
    int fd_;
    State state_ = State::watched;
    std::uint32_t wanted_ = 0;   // events that were asked for
    std::uint32_t watched_ = 0;  // events the system was asked for
    std::function<void()> readable_;
    std::function<void()> writable_;
};

}  // namespace takt::line
