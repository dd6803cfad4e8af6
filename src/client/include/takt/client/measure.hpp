// What this computer adds to an exchange: how late it wakes up, and how long bytes take between two threads.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <system_error>

#include "takt/base/latency_statistics.hpp"
#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/line/loop.hpp"

namespace takt::client {

/// The measurements, in their order.
enum class Subject : std::uint8_t {
    wake_up,   ///< from the instant of a timer to its callback
    loopback,  ///< from a request to its echo, over TCP to another thread
    pty,       ///< the same over a pseudo-terminal
};
inline constexpr std::array kSubjects{Subject::wake_up, Subject::loopback, Subject::pty};

struct MeasureOptions {
    Duration time = std::chrono::seconds(5);  ///< of one measurement
    /// Called on each thread that measures, before it begins; may be empty.
    std::function<void(line::Loop& loop)> begin_thread;
    /// Called on each thread that echoes, before it begins; may be empty.
    std::function<void()> begin_peer;
    /// Set by any thread: the measurement ends soon, with what it has. nullptr: it is never set.
    const std::atomic<bool>* stop = nullptr;
    /// The time since the begin of the measurement; called ten times a second on the thread that measures.
    std::function<void(Duration since)> progress;
};

/// Measures once a millisecond, on a thread of its own, in the event loop that polls and serves. Blocks.
/// @returns one sample for each instant or echo; io_failed with errno where no socket, terminal or thread can
/// be made
[[nodiscard]] Result<LatencyStatistics> measure(Subject subject, const MeasureOptions& options);

/// The error of a thread that could not be started, for which std::thread throws: io_failed with errno.
[[nodiscard]] std::unexpected<Error> no_thread(const std::system_error& error);

/// The figures of a project's `host:` group (docs/guarantees.md).
struct HostBudget {
    Duration jitter{};    ///< the longest wake-up, rounded up to 0.1 ms
    Duration overhead{};  ///< the longest exchange, rounded up to 0.1 ms
};

/// The greatest of what was measured. An exchange contains the work of the peer: the overhead is an upper
/// bound of the samples.
[[nodiscard]] HostBudget budget_of(const LatencyStatistics& wake_up, const LatencyStatistics& loopback,
                                   const LatencyStatistics& pty);

}  // namespace takt::client
