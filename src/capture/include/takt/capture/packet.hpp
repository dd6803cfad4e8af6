// Packets of a capture.
#pragma once

#include <cstdint>
#include <string_view>

#include "takt/base/engine.hpp"

namespace takt::capture {

/// Link layers that this module decodes (www.tcpdump.org/linktypes.html).
enum class LinkType : std::uint16_t {
    null = 0,  ///< BSD loopback: the address family in the byte order of the capturing host
    ethernet = 1,
    raw_bsd = 12,      ///< raw IP in files of some BSD programs
    raw_openbsd = 14,  ///< likewise
    raw = 101,         ///< raw IP, either version
    loop = 108,        ///< OpenBSD loopback: the address family in network order
    linux_cooked = 113,
    user_0 = 147,  ///< without a meaning of its own; here up to user_15: one RTU or ASCII frame
    user_15 = 162,
    ipv4 = 228,
    ipv6 = 229,
    rtac_serial = 250,
    upper_pdu = 252,  ///< the payload of a protocol that a tag before it names (Wireshark, exported PDU)
    linux_cooked_2 = 276,
};

/// The greatest time of a packet: the year 2116. The difference of two times cannot overflow.
inline constexpr std::int64_t kMostTime = INT64_MAX / 2;

/// One packet as the capture has it. Valid during the call that passes it.
struct Packet {
    std::uint64_t number = 0;  ///< from 1 on, over all interfaces, as Wireshark counts
    std::int64_t time_ns = 0;  ///< since 1970, 0..kMostTime
    bool timed = true;  ///< false: the record has no time (simple packet block), or one out of this range
    LinkType link{};
    std::uint32_t interface = 0;        ///< number of the interface in the file, over all sections
    std::string_view interface_name{};  ///< pcapng; empty: it has none
    std::string_view comment{};         ///< pcapng; the first one of the packet
    std::uint32_t original_length = 0;  ///< on the wire; at least data.size()
    Bytes data;                         ///< the captured bytes, from the link-layer header on
};

/// Receives the packets of a capture in the order of the file.
class PacketSink {
public:
    virtual void on_packet(const Packet& packet) = 0;

protected:
    ~PacketSink() = default;
};

/// A packet as a point in time.
struct PacketRef {
    std::uint64_t number = 0;
    std::int64_t time_ns = 0;
    /// A segment that Takt made of a broadcast on a serial line (FrameCapture): it has no response.
    bool serial_broadcast = false;
    friend constexpr bool operator==(const PacketRef&, const PacketRef&) = default;
};

}  // namespace takt::capture
