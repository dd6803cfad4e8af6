// Echoes between two threads.
#pragma once

#include <cstddef>
#include <functional>
#include <thread>

#include "takt/base/latency_statistics.hpp"
#include "takt/base/result.hpp"
#include "takt/line/loop.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::client {

/// Both ends of a way for bytes.
struct Link {
    os::Descriptor near;  ///< not blocking
    os::Descriptor far;   ///< blocking
};

/// A TCP connection over loopback, without delay. @returns io_failed (what, errno)
[[nodiscard]] Result<Link> loopback_link();
/// A pseudo-terminal in raw mode. @returns io_failed (what, errno)
[[nodiscard]] Result<Link> pty_link();

/// A thread that sends back what it receives, until the near end is closed.
class EchoPeer {
public:
    /// @param far  open while the peer lives
    /// @param begin_thread  called first; may be empty
    EchoPeer(int far, const std::function<void()>& begin_thread);
    ~EchoPeer();
    EchoPeer(const EchoPeer&) = delete;
    EchoPeer& operator=(const EchoPeer&) = delete;

private:
    std::thread thread_;
};

/// Sends a request once in `pace`, and records the time until all of its echo is there. It sends no other
/// request before that.
class Exchange {
public:
    static constexpr std::size_t kBytes = 12;  ///< of a request to read registers over Modbus TCP

    /// @param loop, statistics  outlive it. @param near  open while it lives
    Exchange(line::Loop& loop, int near, Duration pace, LatencyStatistics& statistics);

private:
    void send(Instant t);
    void receive();

    int near_;
    Duration pace_;
    LatencyStatistics& statistics_;
    Instant sent_at_;
    std::size_t missing_ = 0;  // bytes of the echo
    line::Timer timer_;
    line::Watch watch_;
};

}  // namespace takt::client
