// The loop of a command that works until a signal ends it (run, serve).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/console/traffic_log.hpp"
#include "takt/line/loop.hpp"
#include "texts.hpp"

namespace takt::app {

/// A loop that ends by a signal, and the log of the frames that pass in it. Outlives all that works in it.
class WorkLoop {
public:
    WorkLoop() = default;
    WorkLoop(const WorkLoop&) = delete;
    WorkLoop& operator=(const WorkLoop&) = delete;

    /// @param traffic  file for the frames; "-": stderr; empty: none
    /// @param reload   what SIGHUP asks for; empty: it stops as the other signals do
    /// @param texts    of the file for the frames
    /// @returns what Loop::create(), Loop::on_signals() and TrafficLog::open() return
    [[nodiscard]] Result<void> begin(const std::string& traffic, std::function<void()> reload,
                                     const Texts& texts);
    /// Without a file for frames.
    [[nodiscard]] Result<void> begin(std::function<void()> reload = {});

    /// @param limit  nothing: until stopped
    void work(std::optional<Duration> limit);

    /// After begin() only.
    [[nodiscard]] line::Loop& loop() { return *loop_; }
    /// nullptr: nothing is logged.
    [[nodiscard]] console::TrafficLog* traffic() { return traffic_.get(); }

private:
    std::unique_ptr<line::Loop> loop_;
    std::unique_ptr<console::TrafficLog> traffic_;
};

}  // namespace takt::app
