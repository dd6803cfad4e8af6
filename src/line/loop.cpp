// The only place that knows Asio: everything else in this room works on Loop, Timer and Watch.
//
// All timers of a loop stand in one heap, with one timer of Asio's for the first of them: thousands of lines
// have a timer each, and Asio's own take five times as much memory. Asio's sit on a timerfd with microsecond
// steps, rounded down; the clock is therefore looked at again before anybody is called back.
#define BOOST_ASIO_NO_DEPRECATED
#include "takt/line/loop.hpp"

#include <fcntl.h>
#include <sys/epoll.h>
#include <boost/asio/basic_waitable_timer.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "takt/line/fd.hpp"

namespace takt::line {
namespace {

namespace asio = boost::asio;
using ErrorCode = boost::system::error_code;
// Bound to this executor, not to any: half the size.
using Executor = asio::io_context::executor_type;
using Clock = std::chrono::steady_clock;
using Alarm = asio::basic_waitable_timer<Clock, asio::wait_traits<Clock>, Executor>;
using Descriptor = asio::posix::basic_stream_descriptor<Executor>;

std::chrono::steady_clock::time_point steady(Instant t) {
    return std::chrono::steady_clock::time_point(t.time_since_epoch());
}

// Asio makes what it watches non-blocking, and a terminal on standard input is shared with other programs.
// Such a descriptor is watched through an epoll descriptor of its own. Empty where that is not needed or
// (files) not possible.
Fd watch_from_outside(int fd) {
    const int flags = ::fcntl(fd, F_GETFL);
    if (flags < 0 || (flags & O_NONBLOCK) != 0) return {};
    Fd outside(::epoll_create1(EPOLL_CLOEXEC));
    epoll_event event{};
    event.events = EPOLLIN;
    if (!outside || ::epoll_ctl(outside.get(), EPOLL_CTL_ADD, fd, &event) != 0) return {};
    return outside;
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

struct TimerState : std::enable_shared_from_this<TimerState> {
    TimerState(Loop::Impl& its_loop, std::function<void(Instant)> on_time)
        : loop(its_loop), callback(std::move(on_time)) {}

    void set(Instant when);

    Loop::Impl& loop;
    std::function<void(Instant)> callback;
    Instant wanted = kNever;
    std::size_t place = 0;  // in the loop's heap, while something is wanted
};

struct Loop::Impl {
    asio::io_context context{1};
    asio::executor_work_guard<Executor> work{context.get_executor()};
    std::optional<asio::signal_set> signals;
    std::function<void(int)> on_signal;
    std::vector<TimerState*> timers;  // a heap: the first to come in front
    Alarm alarm{context};
    Instant alarm_at = kNever;  // not later than the first timer, unless `calling`
    bool calling = false;       // the next expired timer is called as soon as the loop comes round

    void wait_signal() {
        signals->async_wait([this](ErrorCode error, int number) {
            if (error) return;
            wait_signal();
            on_signal(number);
        });
    }

    void add(TimerState& timer) {
        timer.place = timers.size();
        timers.push_back(&timer);
        settle(timer.place);
        arm();
    }

    void remove(const TimerState& timer) {
        const std::size_t place = timer.place;
        put(place, timers.back());
        timers.pop_back();
        if (place < timers.size()) settle(place);
    }

    void arm() {
        if (timers.empty() || calling || timers.front()->wanted >= alarm_at) return;
        alarm_at = timers.front()->wanted;
        alarm.expires_at(steady(alarm_at));
        alarm.async_wait([this](ErrorCode error) {
            if (error) return;
            alarm_at = kNever;
            call_first();
        });
    }

    // One at a time: in between the loop looks after its descriptors, and may be stopped.
    void call_first() {
        const Instant t = now();
        if (timers.empty() || timers.front()->wanted > t) return arm();
        const auto timer = timers.front()->shared_from_this();
        remove(*timer);
        timer->wanted = kNever;
        calling = !timers.empty() && timers.front()->wanted <= t;
        if (calling)
            asio::post(context, [this] {
                calling = false;
                call_first();
            });
        else
            arm();
        timer->callback(t);
    }

    void put(std::size_t place, TimerState* timer) {
        timers[place] = timer;
        timer->place = place;
    }

    [[nodiscard]] bool before(std::size_t a, std::size_t b) const {
        return timers[a]->wanted < timers[b]->wanted;
    }

    void swap(std::size_t a, std::size_t b) {
        TimerState* const first = timers[a];
        put(a, timers[b]);
        put(b, first);
    }

    // Up, then down, to where it belongs.
    void settle(std::size_t place) {
        while (place > 0 && before(place, (place - 1) / 2)) {
            swap(place, (place - 1) / 2);
            place = (place - 1) / 2;
        }
        for (;;) {
            std::size_t first = place;
            for (const std::size_t child : {2 * place + 1, 2 * place + 2})
                if (child < timers.size() && before(child, first)) first = child;
            if (first == place) return;
            swap(place, first);
            place = first;
        }
    }
};

void TimerState::set(Instant when) {
    if (when == wanted) return;
    if (wanted != kNever) loop.remove(*this);
    wanted = when;
    if (wanted != kNever) loop.add(*this);
}

struct Timer::Impl : TimerState {
    using TimerState::TimerState;
};

Loop::Loop(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Loop::~Loop() = default;

Result<std::unique_ptr<Loop>> Loop::create() {
    try {
        return std::unique_ptr<Loop>(new Loop(std::make_unique<Impl>()));
    } catch (const boost::system::system_error& error) {
        return fail(Code::io_failed, "epoll", error.code().value());
    }
}

void Loop::run() {
    impl_->context.run();
}

bool Loop::run_until(const std::function<bool()>& done, Duration limit) {
    const auto end = steady(after(now(), limit));
    while (!done() && !impl_->context.stopped())
        if (impl_->context.run_one_until(end) == 0) break;
    return done();
}

void Loop::stop() {
    impl_->context.stop();
}
bool Loop::stopped() const {
    return impl_->context.stopped();
}

void Loop::post(std::function<void()> task) {
    asio::post(impl_->context, std::move(task));
}

Result<void> Loop::on_signals(std::initializer_list<int> signals, std::function<void(int)> callback) {
    try {
        impl_->on_signal = std::move(callback);
        impl_->signals.emplace(impl_->context);
        for (int number : signals) impl_->signals->add(number);
        impl_->wait_signal();
        return {};
    } catch (const boost::system::system_error& error) {
        impl_->signals.reset();
        return fail(Code::io_failed, "signals", error.code().value());
    }
}

Timer::Timer(Loop& loop, std::function<void(Instant)> callback)
    : impl_(std::make_shared<Impl>(loop.impl(), std::move(callback))) {}

Timer::~Timer() {
    impl_->set(kNever);
}

void Timer::set(Instant when) {
    impl_->set(when);
}
Instant Timer::when() const {
    return impl_->wanted;
}

struct Watch::Impl : std::enable_shared_from_this<Watch::Impl> {
    Impl(asio::io_context& context, std::function<void()> on_readable, std::function<void()> on_writable)
        : descriptor(context), readable(std::move(on_readable)), writable(std::move(on_writable)) {}

    Fd outside;  // outlives the descriptor that watches it
    Descriptor descriptor;
    std::function<void()> readable;
    std::function<void()> writable;
    bool reading = false;
    bool writing = false;
    bool alive = true;

    void want(bool to_write) {
        bool& waiting = to_write ? writing : reading;
        if (!alive || !descriptor.is_open() || std::exchange(waiting, true)) return;
        const auto type = to_write ? Descriptor::wait_write : Descriptor::wait_read;
        descriptor.async_wait(type, [self = shared_from_this(), to_write](ErrorCode error) {
            if (error == asio::error::operation_aborted || !self->alive) return;
            (to_write ? self->writing : self->reading) = false;
            (to_write ? self->writable : self->readable)();
        });
    }
};

Watch::Watch(Loop& loop, int fd, std::function<void()> readable, std::function<void()> writable)
    : impl_(std::make_shared<Impl>(loop.impl().context, std::move(readable), std::move(writable))) {
    impl_->outside = watch_from_outside(fd);
    ErrorCode error;
    impl_->descriptor.assign(impl_->outside ? impl_->outside.get() : fd, error);
}

Watch::~Watch() {
    impl_->alive = false;
    if (impl_->descriptor.is_open()) impl_->descriptor.release();
}

bool Watch::ok() const {
    return impl_->descriptor.is_open();
}

void Watch::want_read() {
    impl_->want(false);
}
void Watch::want_write() {
    impl_->want(true);
}

}  // namespace takt::line
