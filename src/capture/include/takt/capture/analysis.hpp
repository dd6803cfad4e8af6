// The exchanges of a capture.
#pragma once

#include <cstdint>
#include <memory>

#include "takt/capture/packet.hpp"
#include "takt/capture/serial_analyzer.hpp"
#include "takt/capture/tcp_analyzer.hpp"

namespace takt::capture {

class FragmentTable;

/// What the packets of a capture hold.
struct PacketCounts {
    std::uint64_t packets = 0;
    std::uint64_t segments = 0;        ///< of TCP
    std::uint64_t serial = 0;          ///< frames of serial lines
    std::uint64_t other = 0;           ///< not IP, or not TCP
    std::uint64_t fragments = 0;       ///< of IP packets
    std::uint64_t lost_fragments = 0;  ///< of those: of packets that never became complete
    std::uint64_t cut = 0;             ///< captured shorter than their headers
    std::uint64_t malformed = 0;       ///< their headers contradict themselves
    std::uint64_t other_link = 0;
    std::uint16_t first_other_link = 0;  ///< the type of the first of those
    std::uint64_t dropped = 0;           ///< when the capture was made, or by the system
    std::uint64_t untimed = 0;           ///< without a time: left out
    std::uint64_t backwards = 0;         ///< earlier than the packet before
    std::int64_t first_ns = 0;           ///< since 1970
    std::int64_t last_ns = 0;
};

/// Passes the packets of a capture to the analyzers. One owner, one thread.
class Analysis final : public PacketSink {
public:
    Analysis(const TcpAnalyzerConfig& tcp, Duration timeout, ExchangeSink& sink);

    ~Analysis();
    Analysis(const Analysis&) = delete;
    Analysis& operator=(const Analysis&) = delete;

    void on_packet(const Packet& packet) override;
    /// That many packets passed and are not in the capture, in all.
    void set_dropped(std::uint64_t count) { packets_.dropped = count; }
    /// The capture has ended.
    void end();

    [[nodiscard]] const PacketCounts& packets() const { return packets_; }
    [[nodiscard]] TcpCounts tcp() const { return tcp_.counts(); }
    [[nodiscard]] const SerialCounts& serial() const { return serial_.counts(); }

private:
    void count_time(std::int64_t time_ns);
    void count_other(const Packet& packet, Content content);

    [[nodiscard]] Content reassemble(const Packet& packet, const Fragment& fragment, Segment& segment);

    PacketCounts packets_;
    std::unique_ptr<FragmentTable> fragments_;
    TcpAnalyzer tcp_;
    SerialAnalyzer serial_;
};

}  // namespace takt::capture
