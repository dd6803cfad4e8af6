// The times of all requests of a host, from its traffic tap.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/host/session.hpp"

namespace takt::bench {

/// Collects on a thread of its own.
class PollTimes {
public:
    /// @param session  with a tap and events
    /// @param lines    of the project, one device each
    PollTimes(std::unique_ptr<host::Session> session, std::size_t lines, Duration period);
    ~PollTimes();
    PollTimes(const PollTimes&) = delete;
    PollTimes& operator=(const PollTimes&) = delete;

    struct Window {
        std::vector<Duration> lateness;  ///< of the requests in it, ascending
        std::size_t missed = 0;          ///< periods
    };
    /// To be called at the end of the run: the earliest request of a line in the whole run is the one in
    /// time.
    [[nodiscard]] Window window(Instant from, Instant to) const;

    /// Requests that were sent again because the device did not answer in time. They are not in a window.
    [[nodiscard]] std::uint64_t repetitions() const { return repetitions_; }
    /// Links and frames that were lost: there must be none.
    [[nodiscard]] std::uint64_t lost() const { return lost_; }

private:
    void run();
    void read();

    std::unique_ptr<host::Session> session_;
    Duration period_;
    mutable std::mutex mutex_;
    std::vector<std::vector<Instant>> sent_;  // by line; without repetitions
    std::uint64_t missed_ = 0;                // frames, counted so far
    std::atomic<std::uint64_t> repetitions_ = 0;
    std::atomic<std::uint64_t> lost_ = 0;
    std::atomic<bool> ending_ = false;
    std::thread thread_;
};

}  // namespace takt::bench
