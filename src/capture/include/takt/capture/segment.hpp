// TCP segments in packets: link layer, IP and TCP headers.
#pragma once

#include <cstdint>

#include "takt/base/network.hpp"
#include "takt/capture/packet.hpp"

namespace takt::capture {

/// One end of a TCP connection.
struct Endpoint {
    IpAddress address;
    std::uint16_t port = 0;
    friend constexpr bool operator==(const Endpoint&, const Endpoint&) = default;
};

/// A segment with the headers that reassembly needs. Points into its packet.
struct Segment {
    Endpoint source;
    Endpoint destination;
    std::uint32_t sequence = 0;
    std::uint32_t acknowledged = 0;  ///< valid where `ack`
    bool ack = false;
    bool syn = false;
    bool fin = false;
    bool rst = false;
    /// The identification of an IPv4 packet; 0: none. A packet that was captured twice has the same one.
    std::uint16_t identification = 0;
    std::uint32_t length =
        0;          ///< of the payload on the wire; greater than payload.size() if the packet is cut
    Bytes payload;  ///< as far as it was captured
};

/// A part of an IP datagram. Points into its packet.
struct Fragment {
    IpAddress source;
    IpAddress destination;
    std::uint32_t identification = 0;
    std::uint8_t protocol = 0;
    std::uint32_t offset = 0;  ///< of the payload in that of the datagram, in bytes; at most 65,528
    bool more = false;         ///< it is not the last one
    Bytes payload;             ///< all of it was captured
};

/// What a packet holds.
enum class Content : std::uint8_t {
    segment,
    other_link,  ///< a link layer that is not decoded
    not_ip,      ///< ARP, LLDP, …
    not_tcp,     ///< UDP, ICMP, …
    fragment,    ///< of an IP packet, see Fragment
    cut,         ///< captured shorter than its headers
    malformed,   ///< lengths of its headers contradict each other
};

/// Decodes Ethernet with any VLAN tags, Linux cooked (both versions), BSD and OpenBSD loopback and raw IP.
/// Checksums are not verified: adapters compute them after the capture. Nothing is assumed of the bytes.
/// @param segment   is set where the result is Content::segment
/// @param fragment  is set where the result is Content::fragment
[[nodiscard]] Content decode_segment(const Packet& packet, Segment& segment, Fragment& fragment);

/// Decodes a datagram that was made of fragments.
/// @param fragment  one of them
[[nodiscard]] Content decode_datagram(const Fragment& fragment, Bytes payload, Segment& segment);

}  // namespace takt::capture
