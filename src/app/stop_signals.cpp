#include "stop_signals.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <utility>
#include <vector>

namespace takt::app {
namespace {

bool hang_up_ignored() {
    struct sigaction hang_up{};
    return ::sigaction(SIGHUP, nullptr, &hang_up) == 0 && hang_up.sa_handler == SIG_IGN;
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

Result<void> on_stop(line::Loop& loop, std::function<void()> callback) {
    const auto stop = [callback = std::move(callback)](int) { callback(); };
    return hang_up_ignored() ? loop.on_signals({SIGINT, SIGTERM}, stop)
                             : loop.on_signals({SIGINT, SIGTERM, SIGHUP}, stop);
}

Result<void> on_stop_or_reload(line::Loop& loop, std::function<void()> stop, std::function<void()> reload) {
    return loop.on_signals({SIGINT, SIGTERM, SIGHUP}, [stop = std::move(stop), reload = std::move(reload),
                                                       terminals = open_terminals()](int signal) {
        signal == SIGHUP&& std::ranges::none_of(terminals, is_gone) ? reload() : stop();
    });
}

}  // namespace takt::app
