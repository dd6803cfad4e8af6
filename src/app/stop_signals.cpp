#include "stop_signals.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <utility>
#include <vector>

namespace takt::app {
namespace {

bool is_ignored(int number) {
    struct sigaction action{};
    return ::sigaction(number, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

void block_reload(int how) {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGHUP);
    ::pthread_sigmask(how, &signals, nullptr);
}

std::vector<int> open_terminals() {
    std::vector<int> found;
    for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (::isatty(descriptor) == 1) found.push_back(descriptor);
    return found;
}

/// The window of the terminal was closed, or its connection lost.
bool is_gone(int terminal) {
    pollfd asked{.fd = terminal, .events = 0, .revents = 0};
    return ::poll(&asked, 1, 0) == 1 && (asked.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0;
}

}  // namespace

void accept_stop_signals() {
    for (const int number : {SIGINT, SIGTERM})
        if (is_ignored(number)) std::signal(number, SIG_DFL);
}

std::vector<int> stop_signals() {
    std::vector<int> signals{SIGINT, SIGTERM};
    if (!is_ignored(SIGHUP)) signals.push_back(SIGHUP);
    return signals;
}

Result<void> on_stop(line::Loop& loop, std::function<void()> callback) {
    const auto stop = [callback = std::move(callback)](int) { callback(); };
    return is_ignored(SIGHUP) ? loop.on_signals({SIGINT, SIGTERM}, stop)
                              : loop.on_signals({SIGINT, SIGTERM, SIGHUP}, stop);
}

void hold_reload() {
    block_reload(SIG_BLOCK);
}

Result<void> on_stop_or_reload(line::Loop& loop, std::function<void()> stop, std::function<void()> reload) {
    TAKT_CHECK(loop.on_signals({SIGINT, SIGTERM, SIGHUP}, [stop = std::move(stop), reload = std::move(reload),
                                                           terminals = open_terminals()](int signal) {
        signal == SIGHUP&& std::ranges::none_of(terminals, is_gone) ? reload() : stop();
    }));
    block_reload(SIG_UNBLOCK);
    return {};
}

}  // namespace takt::app
