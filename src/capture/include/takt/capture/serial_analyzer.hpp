// Frames of serial lines to Modbus exchanges.
#pragma once

#include <array>
#include <cstdint>
#include <map>

#include "takt/base/time.hpp"
#include "takt/capture/exchange.hpp"
#include "takt/capture/packet.hpp"
#include "takt/capture/serial_pairing.hpp"

namespace takt::capture {

struct SerialCounts {
    std::uint64_t frames = 0;
    std::uint64_t damaged = 0;      ///< wrong checksum or length
    std::uint64_t unmatched = 0;    ///< responses without a request
    std::uint64_t line_errors = 0;  ///< events of an RTAC: framing, parity, overflow, break, lost data
};

/// One frame in each packet: RTU, or ASCII from ':' to CR LF. Link types user_0..user_15 hold the frame
/// alone; rtac_serial has a header of 12 bytes before it (Wireshark, packet-rtacser.c). Of upper_pdu, frames
/// for the dissector "mbrtu" are read; bytes for "data" are damaged frames (FrameCapture).
///
/// SerialPairing decides which frames are requests. The time of a frame is that of its packet. Allocates for
/// each interface. One owner, one thread.
class SerialAnalyzer {
public:
    SerialAnalyzer(Duration timeout, ExchangeSink& sink) : timeout_(timeout), sink_(sink) {}

    /// @param packet  of one of those link types
    void on_packet(const Packet& packet);
    void end();

    [[nodiscard]] const SerialCounts& counts() const { return counts_; }
    [[nodiscard]] static bool is_serial(LinkType link);
    /// The frame in a packet of those link types; empty: an event of the line.
    [[nodiscard]] static Bytes frame_of(const Packet& packet);

private:
    struct Line {
        explicit Line(Duration timeout) : pairing(timeout) {}
        SerialPairing pairing;
        std::array<ObservedRequest, SerialPairing::kSlots> requests;  // by slot
    };

    [[nodiscard]] Line& line_of(std::uint32_t interface);
    void on_upper_pdu(Line& line, const Packet& packet);
    void on_frame(Line& line, const Packet& packet, Bytes frame);
    void give_up(const Line& line, const SerialPairing::Slots& slots, NoResponse why);

    Duration timeout_;
    ExchangeSink& sink_;
    SerialCounts counts_;
    std::map<std::uint32_t, Line> lines_;  // by interface
};

}  // namespace takt::capture
