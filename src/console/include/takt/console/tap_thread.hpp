// Readers of traffic taps on a thread of their own.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "takt/host/session.hpp"
#include "takt/host/traffic_tap.hpp"
#include "takt/model/line.hpp"

namespace takt::console {

using LineOf = std::function<std::optional<model::Line>(const host::TrafficRecord&)>;

/// Where frames come from: a ring that the I/O thread writes and that never makes it wait. Called by one
/// thread.
struct TapSource {
    std::function<std::optional<host::TrafficRecord>()> next;
    std::function<std::uint64_t()> missed;  ///< frames that were overwritten before they were read
    LineOf line_of;
    bool overheard = false;  ///< the frames of others on a line: requests count as received
};

/// @param session  with `traffic`
[[nodiscard]] TapSource tap_source(const std::shared_ptr<host::Session>& session);
[[nodiscard]] TapSource tap_source(const host::TrafficTap& tap);

/// Calls `turn` on a thread of its own each 20 ms, and a last time with `ending`.
class TapThread {
public:
    using Turn = std::function<void(bool ending)>;
    explicit TapThread(Turn turn);
    /// Returns after the last turn.
    ~TapThread();
    TapThread(const TapThread&) = delete;
    TapThread& operator=(const TapThread&) = delete;

private:
    void work();

    Turn turn_;
    std::mutex mutex_;
    std::condition_variable changed_;
    bool ending_ = false;  // guarded by mutex_
    std::thread thread_;
};

}  // namespace takt::console
