// The real-time mode of run, serve, latency and selftest.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/line/loop.hpp"
#include "takt/os/realtime.hpp"
#include "texts.hpp"

namespace takt::app {

/// --realtime, --cpu and --spin.
struct RealtimeMode {
    int priority = 0;                  ///< of SCHED_FIFO; 0: normal scheduling
    std::optional<std::uint32_t> cpu;  ///< nothing: any
    Duration spin{};                   ///< of polling before the thread sleeps
};

/// Below the interrupt threads of a real-time kernel, whose priority is 50.
inline constexpr int kRealtimePriority = 49;

/// For the thread that runs `loop`, before it runs it.
[[nodiscard]] std::vector<os::RealtimeResult> begin_realtime(const RealtimeMode& mode, line::Loop& loop);

/// Prints each step, and why it was not done, to stderr. @param json  also as one object to stdout
void print_realtime(const Texts& texts, const RealtimeMode& mode,
                    const std::vector<os::RealtimeResult>& results, bool json);

}  // namespace takt::app
