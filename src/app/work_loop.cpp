#include "work_loop.hpp"

#include <utility>

#include "stop_signals.hpp"

namespace takt::app {

Result<void> WorkLoop::begin(const std::string& traffic, std::function<void()> reload,
                             console::FileReports reports) {
    TAKT_TRY(loop_, line::Loop::create());
    const auto stop = [this] { loop_->stop(); };
    TAKT_CHECK(reload ? on_stop_or_reload(*loop_, stop, std::move(reload)) : on_stop(*loop_, stop));
    if (traffic.empty()) return {};
    TAKT_TRY(traffic_, console::TrafficLog::open(traffic, std::move(reports)));
    return {};
}

void WorkLoop::work(std::optional<Duration> limit) {
    if (limit)
        loop_->run_until([] { return false; }, *limit);
    else
        loop_->run();
}

}  // namespace takt::app
