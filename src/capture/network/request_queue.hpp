// The requests of one connection that wait for their response.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "network/mbap_stream.hpp"
#include "takt/base/time.hpp"
#include "takt/capture/exchange.hpp"

namespace takt::capture {

/// Requests in flight, matched by transaction, unit and function.
///
/// Equal ones are answered in their order, because a server answers the requests of a TCP connection in their
/// order. There are two exceptions. A response does not answer a request for another quantity or address. And
/// a client that repeats a request after a pause of many response times has given up the first one. Without
/// this rule one lost response would shift all later ones of a client with a constant transaction id.
///
/// At most kMost wait; then, and after `forget`, the oldest is unanswered. Allocates. One owner, one thread.
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
    /// Removes and returns the one that the response answers.
    [[nodiscard]] std::optional<Waiting> take(const Adu& response);
    /// Removes and returns the oldest one if it is older than `forget` at `now_ns`, or if the queue is full.
    [[nodiscard]] std::optional<Waiting> take_expired(std::int64_t now_ns, Duration forget);
    /// Removes and returns the oldest one.
    [[nodiscard]] std::optional<Waiting> take_oldest();

private:
    [[nodiscard]] bool supersedes(const Waiting& later, const Waiting& earlier, Bytes response) const;
    void learn(std::int64_t response_ns);

    std::deque<Waiting> waiting_;
    std::int64_t usual_ns_ = 0;  // response time, smoothed
};

}  // namespace takt::capture
