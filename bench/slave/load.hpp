// The load generator: clients in an epoll loop that check every answer.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "servers.hpp"

namespace bench {

using Clock = std::chrono::steady_clock;

/// One request and its answer; the transaction number is put in when they are used.
struct Exchange {
    std::vector<std::uint8_t> request;
    std::vector<std::uint8_t> response;
    [[nodiscard]] Sizes sizes() const { return {request.size(), response.size()}; }
};

/// A frame of Modbus TCP for unit 1, with transaction 0.
std::vector<std::uint8_t> frame(std::span<const std::uint8_t> pdu);

/// Reading `count` registers from `start` of a device whose registers hold their addresses.
Exchange read_registers(std::uint16_t start, std::uint16_t count);
/// Writing those numbers there again.
Exchange write_registers(std::uint16_t start, std::uint16_t count);

/// A connected, non-blocking socket; -1: refused.
int connect_to(std::uint16_t port);

struct Load {
    std::chrono::duration<double> length{};
    double requests_per_s = 0;
    std::size_t answered = 0;
    std::size_t wrong = 0;             ///< answers that are not the right ones
    std::size_t unanswered = 0;        ///< within the time given to stragglers
    std::vector<double> latencies_us;  ///< ascending; of one request at a time, and of a paced client

    [[nodiscard]] double quantile_us(double q) const;
    /// Adds the results of another run of the same kind.
    void add(const Load& other);
};

/// `connections` clients with `window` requests in flight each, for that long. A client that has got answers
/// sends as many new requests in one piece.
/// @param checked  false for the echo: only the number of bytes is checked
Load flood(std::uint16_t port, const Exchange& exchange, std::size_t connections, std::size_t window,
           std::chrono::milliseconds length, bool checked);

/// One client that sends `per_second` requests a second at a fixed rate, and waits 5 s for late responses.
Load paced(std::uint16_t port, const Exchange& exchange, std::size_t per_second,
           std::chrono::milliseconds length, bool checked);

}  // namespace bench
