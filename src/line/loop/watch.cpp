// A descriptor stays registered with epoll between callbacks. The usual callback asks for the next event, so
// a request costs no epoll_ctl() call. Only an event that was not asked for reduces the registered events.
#include <algorithm>
#include <cerrno>
#include <utility>

#include "loop/loop_impl.hpp"

namespace takt::line {
namespace {

constexpr std::uint32_t kTrouble = EPOLLERR | EPOLLHUP;  // epoll always reports these

}  // namespace

Watch::Watch(Loop& loop, int fd, std::function<void()> readable, std::function<void()> writable)
    : loop_(loop.impl()), fd_(fd), readable_(std::move(readable)), writable_(std::move(writable)) {
    epoll_event event{};
    event.events = watched_ = EPOLLIN;
    event.data.ptr = this;
    if (::epoll_ctl(loop_.epoll.get(), EPOLL_CTL_ADD, fd_, &event) == 0) return;
    state_ = errno == EPERM ? State::always_ready : State::refused;
}

Watch::~Watch() {
    if (state_ == State::watched) ::epoll_ctl(loop_.epoll.get(), EPOLL_CTL_DEL, fd_, nullptr);
    loop_.forget(*this);
}

void Watch::want_read() {
    want(EPOLLIN);
}
void Watch::want_write() {
    want(EPOLLOUT);
}

void Watch::want_hang_up() {
    if (state_ != State::always_ready) want(EPOLLHUP);
}

void Watch::want(std::uint32_t events) {
    if (state_ == State::refused || (wanted_ & events) != 0) return;
    wanted_ |= events;
    if (state_ == State::always_ready)
        loop_.ready.push_back(this);
    else if (state_ == State::left_out || ((watched_ | kTrouble) & events) == 0)
        update_epoll();
}

void Watch::update_epoll() {
    epoll_event event{};
    event.events = watched_ = wanted_;
    event.data.ptr = this;
    const int operation = wanted_ == 0                ? EPOLL_CTL_DEL
                          : state_ == State::left_out ? EPOLL_CTL_ADD
                                                      : EPOLL_CTL_MOD;
    if (::epoll_ctl(loop_.epoll.get(), operation, fd_, &event) != 0) {
        state_ = State::refused;
        return;
    }
    state_ = wanted_ == 0 ? State::left_out : State::watched;
}

void Watch::act(std::uint32_t events) {
    const std::uint32_t due = (events & kTrouble) != 0 ? wanted_ : wanted_ & events;
    if (due == 0) {
        if (state_ == State::watched) update_epoll();
        return;
    }
    wanted_ &= ~due;
    if ((due & (EPOLLIN | EPOLLHUP)) != 0 && !call(&Watch::readable_)) return;
    if ((due & EPOLLOUT) != 0) call(&Watch::writable_);
}

// Returns false if the callback destroyed the watch. The callback is moved out of the watch while it runs.
bool Watch::call(std::function<void()> Watch::* callback) {
    Loop::Impl& loop = loop_;
    void* const outer = std::exchange(loop.calling, this);
    auto running = std::move(this->*callback);
    if (running) running();
    const bool alive = loop.calling == this;
    if (alive) this->*callback = std::move(running);
    loop.calling = outer;
    return alive;
}

void Loop::Impl::forget(const Watch& watch) {
    if (calling == &watch) calling = nullptr;
    for (std::size_t i = event_next; i < event_count; ++i)
        if (events[i].data.ptr == &watch) events[i].data.ptr = nullptr;
    std::erase(ready, &watch);
}

}  // namespace takt::line
