#include "work_loop.hpp"

#include <utility>

#include "output.hpp"
#include "stop_signals.hpp"

namespace takt::app {

Result<void> WorkLoop::begin(std::function<void()> reload) {
    TAKT_TRY(loop_, line::Loop::create());
    const auto stop = [this] { loop_->stop(); };
    return reload ? on_stop_or_reload(*loop_, stop, std::move(reload)) : on_stop(*loop_, stop);
}

Result<void> WorkLoop::begin(const std::string& traffic, std::function<void()> reload, const Texts& texts) {
    TAKT_CHECK(begin(std::move(reload)));
    if (traffic.empty()) return {};
    TAKT_TRY(traffic_, console::TrafficLog::open(traffic, file_reports(texts),
                                                 console::TrafficLog::kFileBytes, texts.language()));
    return {};
}

void WorkLoop::work(std::optional<Duration> limit) {
    if (limit)
        loop_->run_until([] { return false; }, *limit);
    else
        loop_->run();
}

}  // namespace takt::app
