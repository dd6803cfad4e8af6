// Headers: IEEE 802.3 with 802.1Q, LINKTYPE_LINUX_SLL and _SLL2, RFC 791 (IPv4), RFC 8200 (IPv6), RFC 9293
// (TCP).
#include "takt/capture/segment.hpp"

#include <algorithm>
#include <array>
#include <optional>

#include "files/big_endian.hpp"
#include "network/ip_packet.hpp"

namespace takt::capture {
namespace {

constexpr std::uint16_t kIpv4 = 0x0800;
constexpr std::uint16_t kIpv6 = 0x86DD;
constexpr std::size_t kIpv6Header = 40;
constexpr std::size_t kTcpHeader = 20;
constexpr int kMostTags = 4;        // VLAN tags
constexpr int kMostExtensions = 8;  // IPv6 extension headers
// Those with their length in units of 8 bytes: hop-by-hop, routing, destination, mobility, host identity,
// shim6.
constexpr std::array<std::uint8_t, 6> kOptions{0, 43, 60, 135, 139, 140};

/// The network layer of a packet: its EtherType and its bytes.
struct NetworkLayer {
    std::uint16_t type = 0;
    Bytes bytes;
};

using Layer = std::optional<NetworkLayer>;  // nothing: the packet is cut before it

Layer after_header(Bytes bytes, std::size_t type_at, std::size_t header) {
    if (bytes.size() < header) return std::nullopt;
    return NetworkLayer{be16_at(bytes, type_at), bytes.subspan(header)};
}

/// Removes VLAN tags (802.1Q, 802.1ad and the older 0x9100).
Layer without_tags(Layer layer) {
    for (int tags = 0; layer && tags < kMostTags; ++tags) {
        if (layer->type != 0x8100 && layer->type != 0x88A8 && layer->type != 0x9100) break;
        layer = after_header(layer->bytes, 2, 4);
    }
    return layer;
}

/// Decides by the version in the first byte.
Layer raw_ip(Bytes bytes) {
    if (bytes.empty()) return std::nullopt;
    const unsigned version = bytes[0] >> 4U;
    const std::uint16_t other = version == 6 ? kIpv6 : std::uint16_t{0};
    return NetworkLayer{version == 4 ? kIpv4 : other, bytes};
}

/// Both loopback headers are an address family; the version in the packet is more reliable.
Layer loopback(Bytes bytes) {
    if (bytes.size() < 4) return std::nullopt;
    return raw_ip(bytes.subspan(4));
}

/// @returns false: the link layer is unknown
bool network_of(const Packet& packet, Layer& layer) {
    switch (packet.link) {
        case LinkType::ethernet: layer = without_tags(after_header(packet.data, 12, 14)); return true;
        case LinkType::linux_cooked: layer = without_tags(after_header(packet.data, 14, 16)); return true;
        case LinkType::linux_cooked_2: layer = without_tags(after_header(packet.data, 0, 20)); return true;
        case LinkType::null:
        case LinkType::loop: layer = loopback(packet.data); return true;
        case LinkType::raw:
        case LinkType::raw_bsd:
        case LinkType::raw_openbsd:
        case LinkType::ipv4:
        case LinkType::ipv6: layer = raw_ip(packet.data); return true;
        default: return false;
    }
}

/// A packet's IP payload: the captured bytes, and their number on the wire.
struct IpPayload {
    Bytes bytes;
    std::size_t length = 0;
};

// Packets that the kernel passed to the adapter as one for segmentation may have a total length of 0.
/// @param at  of the bytes behind all headers, which are captured
Content fragment_of(Bytes bytes, std::size_t at, std::size_t total, Fragment& fragment) {
    if (total < at) return Content::malformed;
    if (bytes.size() < total) return Content::cut;
    fragment.payload = bytes.subspan(at, total - at);
    return Content::fragment;
}

IpAddress ipv4_address(Bytes bytes) {
    IpAddress address{.bytes = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF}};
    std::copy_n(bytes.begin(), 4, address.bytes.begin() + 12);
    return address;
}

Content decode_ipv4(Bytes bytes, std::size_t on_wire, Segment& segment, Fragment& fragment,
                    IpPayload& payload) {
    if (bytes.size() < kIpv4HeaderBytes) return Content::cut;
    const std::size_t header = std::size_t{4} * (bytes[0] & 0x0FU);
    const std::size_t total = be16_at(bytes, 2) == 0 ? on_wire : be16_at(bytes, 2);
    if (header < kIpv4HeaderBytes || total < header) return Content::malformed;
    if (bytes[9] != kTcpProtocol) return Content::not_tcp;
    if (bytes.size() < header) return Content::cut;
    const auto source = ipv4_address(bytes.subspan(12, 4));
    const auto destination = ipv4_address(bytes.subspan(16, 4));
    if (const auto place = be16_at(bytes, 6) & 0x3FFFU; place != 0) {
        fragment = {.source = source,
                    .destination = destination,
                    .identification = be16_at(bytes, 4),
                    .protocol = kTcpProtocol,
                    .offset = (place & 0x1FFFU) * 8,
                    .more = (place & 0x2000U) != 0};
        return fragment_of(bytes, header, total, fragment);
    }
    segment.identification = be16_at(bytes, 4);
    segment.source.address = source;
    segment.destination.address = destination;
    payload = {bytes.subspan(header, std::min(bytes.size(), total) - header), total - header};
    return Content::segment;
}

/// Skips extension headers, up to that of a fragment. `next` becomes the protocol behind them, `at` its
/// position.
Content skip_extensions(Bytes bytes, std::uint8_t& next, std::size_t& at, Fragment& fragment) {
    for (int i = 0; i < kMostExtensions; ++i) {
        const bool is_options = std::ranges::find(kOptions, next) != kOptions.end();
        const bool is_fragment = next == 44;
        if (!is_options && !is_fragment && next != 51) return Content::segment;
        if (bytes.size() < at + 8) return Content::cut;
        if (const auto place = is_fragment ? be16_at(bytes, at + 2) & 0xFFF9U : 0U; place != 0) {
            fragment.identification = be32_at(bytes, at + 4);
            fragment.protocol = bytes[at];
            fragment.offset = place & 0xFFF8U;
            fragment.more = (place & 1U) != 0;
            at += 8;
            return Content::fragment;
        }
        const std::size_t length = is_fragment  ? 8
                                   : is_options ? (bytes[at + 1] + 1U) * 8
                                                : (bytes[at + 1] + 2U) * 4;
        next = bytes[at];
        at += length;
    }
    return Content::malformed;
}

Content decode_ipv6(Bytes bytes, std::size_t on_wire, Segment& segment, Fragment& fragment,
                    IpPayload& payload) {
    if (bytes.size() < kIpv6Header) return Content::cut;
    std::size_t total = kIpv6Header + be16_at(bytes, 4);
    if (total == kIpv6Header) total = on_wire;
    std::uint8_t next = bytes[6];
    std::size_t at = kIpv6Header;
    std::copy_n(bytes.begin() + 8, 16, segment.source.address.bytes.begin());
    std::copy_n(bytes.begin() + 24, 16, segment.destination.address.bytes.begin());
    if (const auto content = skip_extensions(bytes, next, at, fragment); content != Content::segment) {
        if (content != Content::fragment) return content;
        if (fragment.protocol != kTcpProtocol) return Content::not_tcp;
        fragment.source = segment.source.address;
        fragment.destination = segment.destination.address;
        return fragment_of(bytes, at, total, fragment);
    }
    if (next != kTcpProtocol) return Content::not_tcp;
    if (total < at) return Content::malformed;
    if (bytes.size() < at) return Content::cut;
    segment.identification = 0;
    payload = {bytes.subspan(at, std::min(bytes.size(), total) - at), total - at};
    return Content::segment;
}

Content decode_tcp(const IpPayload& ip, Segment& segment) {
    if (ip.bytes.size() < kTcpHeader) return ip.length < kTcpHeader ? Content::malformed : Content::cut;
    const std::size_t header = std::size_t{4} * (ip.bytes[12] >> 4U);
    if (header < kTcpHeader || header > ip.length) return Content::malformed;
    segment.source.port = be16_at(ip.bytes, 0);
    segment.destination.port = be16_at(ip.bytes, 2);
    segment.sequence = be32_at(ip.bytes, 4);
    segment.acknowledged = be32_at(ip.bytes, 8);
    const std::uint8_t flags = ip.bytes[13];
    segment.fin = (flags & 0x01U) != 0;
    segment.syn = (flags & 0x02U) != 0;
    segment.rst = (flags & 0x04U) != 0;
    segment.ack = (flags & 0x10U) != 0;
    segment.length = static_cast<std::uint32_t>(ip.length - header);
    segment.payload = ip.bytes.subspan(std::min(header, ip.bytes.size()));
    return Content::segment;
}

}  // namespace

Content decode_datagram(const Fragment& fragment, Bytes payload, Segment& segment) {
    if (fragment.protocol != kTcpProtocol) return Content::not_tcp;
    segment.source.address = fragment.source;
    segment.destination.address = fragment.destination;
    segment.identification = static_cast<std::uint16_t>(fragment.identification);
    return decode_tcp({payload, payload.size()}, segment);
}

Content decode_segment(const Packet& packet, Segment& segment, Fragment& fragment) {
    Layer layer;
    if (!network_of(packet, layer)) return Content::other_link;
    if (!layer) return Content::cut;
    const std::size_t before = packet.data.size() - layer->bytes.size();
    const std::size_t on_wire =
        packet.original_length - std::min<std::size_t>(before, packet.original_length);
    IpPayload payload;
    Content content = Content::not_ip;
    if (layer->type == kIpv4) content = decode_ipv4(layer->bytes, on_wire, segment, fragment, payload);
    if (layer->type == kIpv6) content = decode_ipv6(layer->bytes, on_wire, segment, fragment, payload);
    return content == Content::segment ? decode_tcp(payload, segment) : content;
}

}  // namespace takt::capture
