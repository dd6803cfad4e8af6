// The requests of one connection that wait for their response.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "takt/base/time.hpp"
#include "takt/capture/exchange.hpp"

namespace takt::capture {

/// Requests in flight, matched by transaction, unit and function.
///
/// Equal ones are answered in their order. A server answers each request of a TCP connection, so the first
/// response belongs to the first request. At most kMost wait; then, and after `forget`, the oldest is
/// unanswered. Allocates. One owner, one thread.
class RequestQueue {
public:
    static constexpr std::size_t kMost = 256;

    struct Waiting {
        std::uint16_t transaction = 0;
        std::uint8_t unit = 0;
        std::uint8_t function = 0;
        std::uint32_t items = 0;
        PacketRef packet;
        std::uint64_t retransmissions = 0;  ///< of the connection, when it was sent
    };

    /// @returns whether an equal one (transaction, unit, function) waits already
    bool push(const Waiting& request);
    /// Removes and returns the oldest one that the response answers.
    /// @param function  of the request: without the exception bit
    [[nodiscard]] std::optional<Waiting> take(std::uint16_t transaction, std::uint8_t unit,
                                              std::uint8_t function);
    /// Removes and returns the oldest one if it is older than `forget` at `now_ns`, or if the queue is full.
    [[nodiscard]] std::optional<Waiting> take_expired(std::int64_t now_ns, Duration forget);
    /// Removes and returns the oldest one.
    [[nodiscard]] std::optional<Waiting> take_oldest();

private:
    std::deque<Waiting> waiting_;
};

}  // namespace takt::capture
