// The event loop blocks in one system call, epoll_wait(). A timerfd wakes it for the earliest timer, an
// eventfd for tasks posted by other threads.
//
// One round has three phases: descriptor events, expired timers, posted tasks. A phase handles only what was
// ready when it began, so a callback that rearms itself cannot starve the other phases.
#include "takt/line/loop.hpp"

#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <span>
#include <system_error>
#include <utility>

#include "loop/loop_impl.hpp"

namespace takt::line {
namespace {

timespec time_of(Instant t) {
    using namespace std::chrono;
    // A zero value disarms a timerfd.
    const auto ns = std::max<std::int64_t>(t.time_since_epoch().count(), 1);
    constexpr std::int64_t kSecond = 1'000'000'000;
    return {static_cast<time_t>(ns / kSecond), static_cast<long>(ns % kSecond)};
}

}  // namespace

Instant now() {
    return Instant(std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
}

std::chrono::system_clock::time_point wall_clock(Instant t) {
    const auto ago = now() - t;
    return std::chrono::system_clock::now() -
           std::chrono::duration_cast<std::chrono::system_clock::duration>(ago);
}

Result<void> Loop::Impl::open() {
    epoll.reset(::epoll_create1(EPOLL_CLOEXEC));
    alarm.reset(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK));
    bell.reset(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
    for (const os::Descriptor* fd : {&alarm, &bell}) {
        epoll_event event{};
        event.events = EPOLLIN | EPOLLET;  // edge-triggered: the counters need not be read
        if (!epoll || !*fd || ::epoll_ctl(epoll.get(), EPOLL_CTL_ADD, fd->get(), &event) != 0)
            return fail(Code::io_failed, "epoll", errno);
    }
    return {};
}

bool Loop::Impl::look_up(os::Worker::Job job) {
    constexpr os::Worker::Options kPool{.threads = 32,
                                        .queue = 4096,
                                        .at_end = os::Worker::AtEnd::discard,
                                        .join_timeout = std::chrono::milliseconds(0)};
    try {
        if (!lookups) lookups = std::make_unique<os::Worker>(kPool);
    } catch (const std::system_error&) {
        return false;  // no thread can be started
    }
    return lookups->post(std::move(job));
}

void Loop::Impl::ring() const {
    const std::uint64_t once = 1;
    if (::write(bell.get(), &once, sizeof once) < 0) {
        // EAGAIN: the counter is full, so a wake-up is already pending.
    }
}

bool Loop::Impl::run_one(Instant end) {
    for (;;) {
        switch (phase) {
            case Phase::events:
                if (run_event()) return true;
                phase = Phase::timers;
                phase_time = now();
                phase_left = timers.size();
                break;
            case Phase::timers:
                if (run_timer()) return true;
                phase = Phase::tasks;
                {
                    const std::lock_guard lock(mutex);
                    phase_left = tasks.size();
                }
                break;
            case Phase::tasks:
                if (run_task()) return true;
                phase = Phase::done;
                break;
            case Phase::done:
                if (stopped || now() >= end) return false;
                wait(end);
                phase = Phase::events;
                break;
        }
    }
}

void Loop::Impl::wait(Instant end) {
    bool at_once = !ready.empty();
    {
        const std::lock_guard lock(mutex);
        at_once = at_once || !tasks.empty();
    }
    Instant until = std::min(timers.next(), end);
    int count = 0;
    if (spin > Duration::zero() && !at_once) {
        count = spin_until(std::min(until, spin_end()));
        at_once = count != 0;
        until = std::min(until, spin_again());
    }
    at_once = at_once || until <= now();
    if (!at_once) set_alarm(until);
    constexpr int kForever = -1;
    if (count == 0) count = poll_events(at_once ? 0 : kForever);
    ready_left = ready.size();
    event_next = 0;
    event_count = static_cast<std::size_t>(std::max(count, 0));
    if (spin > Duration::zero()) note_arrival();
}

int Loop::Impl::poll_events(int timeout_ms) {
    return ::epoll_wait(epoll.get(), events.data(), static_cast<int>(kEvents), timeout_ms);
}

// Tasks of other threads arrive as an event of the bell.
int Loop::Impl::spin_until(Instant until) {
    int count = 0;
    while (count == 0 && now() < until) count = poll_events(0);
    return count;
}

// The loop wakes up early enough for the lateness of its timer. An event may be late by as much as the spin.
Instant Loop::Impl::spin_end() const {
    const Instant t = now();
    const Instant expected = forecast->next();
    const bool soon = expected > t && expected - t <= spin + kTimerLateness;
    return after(soon ? expected : t, spin);
}

Instant Loop::Impl::spin_again() const {
    const Instant expected = forecast->next();
    const Instant t = now();
    return expected == kNever || expected - t <= spin + kTimerLateness ? kNever
                                                                       : expected - spin - kTimerLateness;
}

void Loop::Impl::note_arrival() {
    const auto pending = std::span(events).first(event_count);
    if (std::ranges::any_of(pending, [](const epoll_event& event) { return event.data.ptr != nullptr; }))
        forecast->on_arrival(now());
}

// An alarm that is set for an earlier instant stays. It causes one spurious wake-up, and setting a timer to a
// later instant needs no system call.
void Loop::Impl::set_alarm(Instant when) {
    const bool pending = alarm_at != kNever && alarm_at > now();
    if (when == kNever || (pending && alarm_at <= when)) return;
    alarm_at = when;
    itimerspec setting{};
    setting.it_value = time_of(when);
    ::timerfd_settime(alarm.get(), TFD_TIMER_ABSTIME, &setting, nullptr);
}

bool Loop::Impl::run_event() {
    while (event_next < event_count) {
        const epoll_event event = events[event_next++];
        auto* const watch = static_cast<Watch*>(event.data.ptr);
        if (!watch) continue;  // timerfd, eventfd, or a watch destroyed in this round
        watch->act(event.events);
        return true;
    }
    if (ready.empty() || ready_left == 0) return false;
    --ready_left;
    Watch* const file = ready.front();
    ready.pop_front();
    file->act(EPOLLIN | EPOLLOUT);
    return true;
}

bool Loop::Impl::run_timer() {
    if (phase_left == 0) return false;
    --phase_left;
    Timer* const timer = timers.take_due(phase_time);
    if (!timer) return false;
    timer->expire(now());
    return true;
}

bool Loop::Impl::run_task() {
    if (phase_left == 0) return false;
    --phase_left;
    std::function<void()> task;
    {
        const std::lock_guard lock(mutex);
        task = std::move(tasks.front());
        tasks.pop_front();
    }
    task();
    return true;
}

Loop::Loop(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Loop::~Loop() = default;

Result<std::unique_ptr<Loop>> Loop::create() {
    auto impl = std::make_unique<Impl>();
    TAKT_CHECK(impl->open());
    return std::unique_ptr<Loop>(new Loop(std::move(impl)));
}

void Loop::run() {
    while (!impl_->stopped) impl_->run_one(kNever);
}

bool Loop::run_until(const std::function<bool()>& done, Duration limit) {
    const Instant end = after(now(), limit);
    while (!done() && !impl_->stopped)
        if (!impl_->run_one(end)) break;
    return done();
}

void Loop::set_spin(Duration spin) {
    impl_->spin = spin;
    impl_->forecast.reset();
    if (spin > Duration::zero()) impl_->forecast.emplace(spin);
}

void Loop::stop() {
    impl_->stopped = true;
    impl_->ring();
}
bool Loop::stopped() const {
    return impl_->stopped;
}

void Loop::post(std::function<void()> task) {
    {
        const std::lock_guard lock(impl_->mutex);
        impl_->tasks.push_back(std::move(task));
    }
    impl_->ring();
}

Result<void> Loop::on_signals(std::initializer_list<int> signals, std::function<void(int)> callback) {
    impl_->signal_watch.reset();
    impl_->signals.reset();
    TAKT_TRY(auto pipe, SignalPipe::open(signals));
    impl_->signals.emplace(std::move(pipe));
    impl_->signal_watch = std::make_unique<Watch>(*this, impl_->signals->fd(),
                                                  [impl = impl_.get(), callback = std::move(callback)] {
                                                      const int number = impl->signals->take();
                                                      impl->signal_watch->want_read();
                                                      if (number != 0) callback(number);
                                                  });
    impl_->signal_watch->want_read();
    return {};
}

}  // namespace takt::line
