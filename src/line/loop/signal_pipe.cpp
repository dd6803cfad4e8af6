// The self-pipe technique: the signal handler writes the signal's number to a non-blocking pipe, and the
// event loop reads it. Only async-signal-safe calls are made in the handler.
#include "loop/signal_pipe.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>

namespace takt::line {
namespace {

// The only state that the handlers use.
std::atomic<int> g_writing_end = -1;
std::atomic<int> g_stop_signal = 0;

constexpr unsigned kGrace = 5;  // seconds

// The loop, or what follows it, hangs: for example in a write to a terminal that is not read.
void end_by_signal(int) {
    std::signal(g_stop_signal, SIG_DFL);
    std::raise(g_stop_signal);
}

void pass_on(int number) {
    const int error = errno;
    if (number != SIGHUP && g_stop_signal.exchange(number) == 0) ::alarm(kGrace);
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
    SignalPipe pipe{os::Descriptor(ends[0]), os::Descriptor(ends[1])};
    g_writing_end = ends[1];
    TAKT_CHECK(pipe.handle(SIGALRM, end_by_signal));
    for (const int number : signals) TAKT_CHECK(pipe.handle(number, pass_on));
    return pipe;
}

Result<void> SignalPipe::handle(int number, void (*handler)(int)) {
    struct sigaction action{};
    struct sigaction before{};
    action.sa_handler = handler;
    action.sa_flags = SA_RESTART;
    sigfillset(&action.sa_mask);
    if (::sigaction(number, &action, &before) != 0) return fail(Code::io_failed, "signals", errno);
    before_.emplace_back(number, before);
    return {};
}

SignalPipe::~SignalPipe() {
    if (before_.empty()) return;
    if (g_stop_signal.exchange(0) != 0) ::alarm(0);
    for (const auto& [number, action] : before_) ::sigaction(number, &action, nullptr);
    int own = writing_.get();
    if (own >= 0) g_writing_end.compare_exchange_strong(own, -1);
}

int SignalPipe::take() const {
    std::uint8_t number = 0;
    return ::read(end_.get(), &number, 1) == 1 ? number : 0;
}

}  // namespace takt::line
