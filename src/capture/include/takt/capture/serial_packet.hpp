// What a packet of a capture has of a serial line.
#pragma once

#include <cstdint>

#include "takt/base/engine.hpp"
#include "takt/base/inplace_vector.hpp"
#include "takt/capture/packet.hpp"
#include "takt/wire/frame.hpp"

namespace takt::capture {

/// Who sent a frame.
enum class Sender : std::uint8_t { unknown, master, slave };

/// Reads the frame of a serial line in one packet, as it was on the line:
///
/// - link types user_0..user_15: the packet is the frame;
/// - rtac_serial: the frame follows a header of 12 bytes (Wireshark, packet-rtacser.c);
/// - upper_pdu for the dissector "mbrtu" is a frame, for "data" damaged bytes;
/// - a capture of Takt (FrameCapture): the segment is the frame with another header, and the last part of the
///   packet's comment is the frame itself. Both must have the same unit and PDU. The port names the sender.
class SerialPacket {
public:
    enum class Kind : std::uint8_t {
        none,     ///< it has nothing of a serial line
        frame,    ///< its checksum is not verified
        damaged,  ///< bytes that were no frame
    };

    /// @param packet  its data must outlive this
    explicit SerialPacket(const Packet& packet);

    [[nodiscard]] Kind kind() const { return kind_; }
    /// Valid as long as this and the packet.
    [[nodiscard]] Bytes bytes() const { return decoded_.empty() ? bytes_ : decoded_.span(); }
    [[nodiscard]] Sender sender() const { return sender_; }

private:
    void read_upper_pdu(const Packet& packet);
    void read_segment(const Packet& packet);

    Kind kind_ = Kind::none;
    Sender sender_ = Sender::unknown;
    Bytes bytes_;
    wire::FrameBytes decoded_;  // the frame of a comment
};

}  // namespace takt::capture
