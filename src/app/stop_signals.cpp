#include "stop_signals.hpp"

#include <csignal>
#include <utility>

namespace takt::app {
namespace {

bool hang_up_ignored() {
    struct sigaction hang_up{};
    return ::sigaction(SIGHUP, nullptr, &hang_up) == 0 && hang_up.sa_handler == SIG_IGN;
}

}  // namespace

Result<void> on_stop(line::Loop& loop, std::function<void()> callback) {
    const auto stop = [callback = std::move(callback)](int) { callback(); };
    return hang_up_ignored() ? loop.on_signals({SIGINT, SIGTERM}, stop)
                             : loop.on_signals({SIGINT, SIGTERM, SIGHUP}, stop);
}

Result<void> on_stop_or_reload(line::Loop& loop, std::function<void()> stop, std::function<void()> reload) {
    return loop.on_signals({SIGINT, SIGTERM, SIGHUP},
                           [stop = std::move(stop), reload = std::move(reload)](int signal) {
                               signal == SIGHUP ? reload() : stop();
                           });
}

}  // namespace takt::app
