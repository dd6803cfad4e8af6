// The only place that knows Asio: everything else in this room works on Loop, Timer and Watch.
//
// Asio's timers sit on a timerfd with microsecond steps, rounded down; Timer therefore looks at the clock
// again before it calls back.
#define BOOST_ASIO_NO_DEPRECATED
#include "takt/line/loop.hpp"

#include <fcntl.h>
#include <sys/epoll.h>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <optional>
#include <utility>

#include "takt/line/fd.hpp"

namespace takt::line {
namespace {

namespace asio = boost::asio;
using ErrorCode = boost::system::error_code;

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

struct Loop::Impl {
    asio::io_context context{1};
    asio::executor_work_guard<asio::io_context::executor_type> work{context.get_executor()};
    std::optional<asio::signal_set> signals;
    std::function<void(int)> on_signal;

    void wait_signal() {
        signals->async_wait([this](ErrorCode error, int number) {
            if (error) return;
            wait_signal();
            on_signal(number);
        });
    }
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

struct Timer::Impl : std::enable_shared_from_this<Timer::Impl> {
    Impl(asio::io_context& context, std::function<void(Instant)> on_time)
        : timer(context), callback(std::move(on_time)) {}

    asio::steady_timer timer;
    std::function<void(Instant)> callback;
    Instant wanted = kNever;

    void set(Instant when) {
        if (when == wanted) return;
        wanted = when;
        if (when == kNever) {
            timer.cancel();
        } else {
            timer.expires_at(steady(when));
            wait();
        }
    }

    void wait() {
        timer.async_wait([self = shared_from_this()](ErrorCode error) {
            if (!error) self->expired();
        });
    }

    // Also reached by a wait that had expired before the timer was moved: then the wait for the new moment
    // is to come.
    void expired() {
        const Instant t = now();
        if (t < wanted) return;
        wanted = kNever;
        callback(t);
    }
};

Timer::Timer(Loop& loop, std::function<void(Instant)> callback)
    : impl_(std::make_shared<Impl>(loop.impl().context, std::move(callback))) {}

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
    asio::posix::stream_descriptor descriptor;
    std::function<void()> readable;
    std::function<void()> writable;
    bool reading = false;
    bool writing = false;
    bool alive = true;

    void want(asio::posix::stream_descriptor::wait_type type, bool Impl::* waiting,
              std::function<void()> Impl::* callback) {
        if (!alive || !descriptor.is_open() || std::exchange(this->*waiting, true)) return;
        descriptor.async_wait(type, [self = shared_from_this(), waiting, callback](ErrorCode error) {
            Impl& impl = *self;
            if (error == asio::error::operation_aborted || !impl.alive) return;
            impl.*waiting = false;
            (impl.*callback)();
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
    impl_->want(asio::posix::stream_descriptor::wait_read, &Impl::reading, &Impl::readable);
}
void Watch::want_write() {
    impl_->want(asio::posix::stream_descriptor::wait_write, &Impl::writing, &Impl::writable);
}

}  // namespace takt::line
