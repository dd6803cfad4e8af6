// TCP segments of many connections to Modbus exchanges.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "takt/capture/exchange.hpp"
#include "takt/capture/segment.hpp"
#include "takt/capture/tcp_stream.hpp"
#include "takt/wire/frame.hpp"

namespace takt::capture {

struct TcpAnalyzerConfig {
    /// Ports of servers. A connection to another port counts if its bytes are Modbus TCP.
    std::vector<std::uint16_t> ports{502};
    /// Of the messages: MBAP, or RTU or ASCII frames in the byte stream. Nothing: MBAP, unless a connection
    /// without a message has a segment that is one RTU or ASCII frame with a good checksum.
    std::optional<wire::Framing> framing;
    /// Requests without a response are given up after this time.
    Duration forget = std::chrono::seconds(60);
};

/// What was seen beside the exchanges.
struct TcpCounts {
    StreamCounts streams;
    std::uint64_t connections = 0;         ///< with Modbus messages
    std::uint64_t serial_framing = 0;      ///< of them those whose messages are RTU or ASCII frames
    std::uint64_t foreign = 0;             ///< connections of other protocols
    std::uint64_t resynchronisations = 0;  ///< times that the begin of a message had to be searched
    std::uint64_t skipped_bytes = 0;       ///< that belong to no complete message
    std::uint64_t unmatched = 0;           ///< responses without a request
    std::uint64_t repeated_ids = 0;        ///< requests whose transaction, unit and function were in flight
    std::uint64_t evicted = 0;             ///< connections forgotten because there were too many at a time
};

/// Finds the exchanges of all connections.
///
/// The client is the end that sent SYN; without one, the end whose peer has one of the ports, else the higher
/// port, until a message shows otherwise. Keeps the kMostConnections that were used last. Allocates for each
/// connection and for segments that wait. One owner, one thread.
class TcpAnalyzer {
public:
    static constexpr std::size_t kMostConnections = 4096;

    TcpAnalyzer(TcpAnalyzerConfig config, ExchangeSink& sink);
    ~TcpAnalyzer();
    TcpAnalyzer(const TcpAnalyzer&) = delete;
    TcpAnalyzer& operator=(const TcpAnalyzer&) = delete;

    void on_segment(const Segment& segment, const PacketRef& packet);
    /// The capture has ended: reports the requests that still wait.
    void end();

    [[nodiscard]] TcpCounts counts() const;

private:
    class Table;
    std::unique_ptr<Table> table_;
};

}  // namespace takt::capture
