// The self-pipe technique: the signal handler writes the signal's number to a non-blocking pipe, and the
// event loop reads it. Only async-signal-safe calls are made in the handler.
#include "signal_pipe.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>

namespace takt::line {
namespace {

std::atomic<int> g_writing_end = -1;  // the only state that the handler uses

void pass_on(int number) {
    const int error = errno;
    const auto byte = static_cast<std::uint8_t>(number);
    const int fd = g_writing_end;
    if (fd >= 0 && ::write(fd, &byte, 1) < 0) {
        // The pipe is full of signals that are not handled yet. This one is dropped.
    }
    errno = error;
}

}  // namespace

Result<SignalPipe> SignalPipe::open(std::initializer_list<int> signals) {
    int ends[2] = {-1, -1};
    if (::pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) return fail(Code::io_failed, "signals", errno);
    SignalPipe pipe{Fd(ends[0]), Fd(ends[1])};
    g_writing_end = ends[1];
    for (const int number : signals) {
        struct sigaction action{};
        struct sigaction before{};
        action.sa_handler = pass_on;
        action.sa_flags = SA_RESTART;
        sigfillset(&action.sa_mask);
        if (::sigaction(number, &action, &before) != 0) return fail(Code::io_failed, "signals", errno);
        pipe.before_.emplace_back(number, before);
    }
    return pipe;
}

SignalPipe::~SignalPipe() {
    for (const auto& [number, action] : before_) ::sigaction(number, &action, nullptr);
    int own = writing_.get();
    if (own >= 0) g_writing_end.compare_exchange_strong(own, -1);
}

int SignalPipe::take() const {
    std::uint8_t number = 0;
    return ::read(end_.get(), &number, 1) == 1 ? number : 0;
}

}  // namespace takt::line
