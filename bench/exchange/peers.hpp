// The two peers of the benchmark: a blocking echo, and `takt serve`, each a process of its own.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "takt/os/descriptor.hpp"

namespace takt::bench {

/// Where and how a peer runs.
struct PeerOptions {
    int cpu = 0;
    bool realtime = true;  ///< SCHED_FIFO
    std::optional<std::chrono::microseconds> spin;
};

/// A process that listens on loopback, and a connection to it. Is killed at the end.
class Peer {
public:
    /// Sends back what it receives, with blocking calls. Throws Failure.
    [[nodiscard]] static Peer echo(const PeerOptions& options);
    /// `takt serve`, a blank device, from the folder of this program. Throws Failure.
    [[nodiscard]] static Peer takt(const PeerOptions& options);
    ~Peer();
    Peer(Peer&& other) noexcept;
    Peer& operator=(Peer&&) = delete;

    /// Sends the request and waits for `expected` bytes. Throws Failure when the peer has ended.
    /// @returns the time between
    [[nodiscard]] std::chrono::nanoseconds exchange(const std::vector<std::uint8_t>& request,
                                                    std::size_t expected) const;

private:
    Peer(pid_t process, os::Descriptor socket) : process_(process), socket_(std::move(socket)) {}

    pid_t process_ = -1;
    os::Descriptor socket_;
};

}  // namespace takt::bench
