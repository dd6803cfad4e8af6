#include "takt/app/stop_signals.hpp"

#include <csignal>
#include <utility>

namespace takt::app {

Result<void> on_stop(line::Loop& loop, std::function<void()> callback) {
    const auto stop = [callback = std::move(callback)](int) { callback(); };
    struct sigaction hang_up{};
    const bool ignored = ::sigaction(SIGHUP, nullptr, &hang_up) == 0 && hang_up.sa_handler == SIG_IGN;
    return ignored ? loop.on_signals({SIGINT, SIGTERM}, stop)
                   : loop.on_signals({SIGINT, SIGTERM, SIGHUP}, stop);
}

}  // namespace takt::app
