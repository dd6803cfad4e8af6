#include "takt/capture/frame_capture.hpp"

#include <algorithm>
#include <optional>

#include "files/big_endian.hpp"
#include "network/ip_packet.hpp"
#include "network/upper_pdu.hpp"
#include "takt/base/ascii.hpp"
#include "takt/wire/function.hpp"

namespace takt::capture {
namespace {

constexpr std::uint16_t kFirstClientPort = 49152;

std::string_view text_of(Bytes bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The port in "192.0.2.7:50100".
std::optional<std::uint16_t> port_of(std::string_view peer) {
    const auto colon = peer.rfind(':');
    if (colon == std::string_view::npos || colon + 1 == peer.size()) return std::nullopt;
    std::uint32_t port = 0;
    for (const char digit : peer.substr(colon + 1)) {
        if (digit < '0' || digit > '9' || port > 6553) return std::nullopt;
        port = port * 10 + static_cast<std::uint32_t>(digit - '0');
    }
    return port >= 1 && port <= 0xFFFF ? std::optional(static_cast<std::uint16_t>(port)) : std::nullopt;
}

std::optional<IpAddress> address_of(std::string_view text) {
    const auto with_port = parse_peer(text);
    return with_port ? with_port : parse_ip(text);
}

IpAddress numbered(std::uint32_t address) {
    IpAddress result;
    result.bytes[10] = result.bytes[11] = 0xFF;
    for (unsigned i = 0; i < 4; ++i)
        result.bytes[12 + i] = static_cast<std::uint8_t>(address >> (24U - 8 * i));
    return result;
}

/// Both ends in the same version of IP.
std::pair<Endpoint, Endpoint> ends_of(const CapturedFrame& frame) {
    const auto number = static_cast<std::uint32_t>(frame.line);
    const auto client = address_of(frame.client);
    const auto server = address_of(frame.server);
    const auto port = client ? port_of(frame.client) : std::nullopt;
    const auto numbered_port = static_cast<std::uint16_t>(kFirstClientPort + number % 16384);
    Endpoint from{client.value_or(numbered(0x0A000001)), port.value_or(numbered_port)};
    Endpoint to{server.value_or(numbered(0x0A010001U + number % 65000)), FrameCapture::kServerPort};
    if (from.address.is_ipv4() == to.address.is_ipv4()) return {from, to};
    // An address that was made up is put into the other version: ::10.0.0.1.
    auto& made_up = client ? to.address : from.address;
    if (made_up.is_ipv4()) made_up.bytes[10] = made_up.bytes[11] = 0;
    return {from, to};
}

std::string hex(Bytes bytes) {
    std::string text;
    for (const auto byte : bytes) {
        if (!text.empty()) text += ' ';
        text += hex_digit(byte >> 4U);
        text += hex_digit(byte);
    }
    return text;
}

/// The bytes of a serial frame: ASCII as its text without CR LF, RTU as numbers.
std::string raw_text(const CapturedFrame& frame) {
    const bool is_text = frame.framing == wire::Framing::ascii && frame.raw.size() > 2 &&
                         std::ranges::all_of(frame.raw.first(frame.raw.size() - 2),
                                             [](std::uint8_t byte) { return byte >= ' ' && byte < 0x7F; });
    return is_text ? std::string(text_of(frame.raw.first(frame.raw.size() - 2))) : hex(frame.raw);
}

void add_part(std::string& text, std::string_view part) {
    if (!text.empty() && !part.empty()) text += FrameCapture::kCommentSeparator;
    text += part;
}

}  // namespace

void FrameCapture::begin_file(std::string& out) {
    interfaces_.clear();
    captured_ = lost_ = 0;
    append_section(out);
}

std::uint32_t FrameCapture::interface_of(std::size_t line, LinkType link, std::string_view name,
                                         std::string& out) {
    const auto number = static_cast<std::uint32_t>(interfaces_.size());
    const auto found = interfaces_.try_emplace({line, link}, number);
    if (found.second) append_interface(out, link, name);
    return found.first->second;
}

FrameCapture::Connection& FrameCapture::connection_of(const CapturedFrame& frame) {
    ConnectionKey key{frame.line, frame.client};
    if (connections_.size() >= kMostConnections && !connections_.contains(key))
        connections_.erase(
            std::ranges::min_element(connections_, {}, [](const auto& entry) { return entry.second.used; }));
    auto& connection = connections_[std::move(key)];
    connection.used = ++uses_;
    return connection;
}

std::uint16_t FrameCapture::identifier_of(Connection& connection, const CapturedFrame& frame) {
    auto& known = connection.identifiers;
    const auto function = wire::requested_function(frame.pdu[0]);
    if (frame.request) {
        if (known.size() >= kMostIdentifiers) known.clear();
        known[{frame.unit, function}] = known[{frame.unit, 0}] = ++connection.last_identifier;
        return connection.last_identifier;
    }
    for (const std::uint8_t each : {function, std::uint8_t{0}})
        if (const auto found = known.find({frame.unit, each}); found != known.end()) return found->second;
    return ++connection.last_identifier;
}

std::string FrameCapture::payload_of(Connection& connection, const CapturedFrame& frame) {
    if (frame.framing == wire::Framing::tcp && !frame.raw.empty()) return std::string(text_of(frame.raw));
    const auto identifier = identifier_of(connection, frame);
    std::string payload;
    put_be16(payload, identifier);
    put_be16(payload, 0);
    put_be16(payload, frame.pdu.size() + 1);
    payload += static_cast<char>(frame.unit);
    payload += text_of(frame.pdu);
    return payload;
}

std::string FrameCapture::segment_of(const CapturedFrame& frame) {
    auto& connection = connection_of(frame);
    const auto payload = payload_of(connection, frame);
    const auto [client, server] = ends_of(frame);
    auto& own = frame.request ? connection.sequence_of_client : connection.sequence_of_server;
    const auto other = frame.request ? connection.sequence_of_server : connection.sequence_of_client;
    auto packet = tcp_packet({.source = frame.request ? client : server,
                              .destination = frame.request ? server : client,
                              .sequence = own,
                              .acknowledged = other},
                             payload);
    own += static_cast<std::uint32_t>(payload.size());
    return packet;
}

std::string FrameCapture::comment_of(const CapturedFrame& frame) {
    std::string comment;
    if (unreported_ > 0)
        comment = std::to_string(std::exchange(unreported_, 0)) + " frames before this one were lost";
    if (!frame.fault.empty()) add_part(comment, "dropped: " + std::string(frame.fault));
    add_part(comment, frame.device);
    if (frame.fault.empty() && frame.framing != wire::Framing::tcp) add_part(comment, raw_text(frame));
    return comment;
}

void FrameCapture::add(const CapturedFrame& frame, std::string& out) {
    ++captured_;
    const bool is_frame = frame.fault.empty() && !frame.pdu.empty();
    const auto comment = comment_of(frame);
    const auto data = is_frame ? segment_of(frame) : upper_pdu(kDataDissector, text_of(frame.raw));
    const auto link = is_frame ? LinkType::raw : LinkType::upper_pdu;
    const auto interface = interface_of(frame.line, link, frame.line_name, out);
    append_packet(out, {.interface = interface,
                        .time_ns = frame.wall_ns,
                        .direction = frame.direction,
                        .data = data,
                        .comment = comment});
}

void FrameCapture::add_loss(std::uint64_t count) {
    lost_ += count;
    unreported_ += count;
}

void FrameCapture::end_file(std::int64_t wall_ns, std::string& out) {
    const auto interface =
        interfaces_.empty() ? interface_of(0, LinkType::raw, "takt", out) : interfaces_.begin()->second;
    append_statistics(
        out, {.interface = interface, .time_ns = wall_ns, .received = captured_ + lost_, .dropped = lost_});
}

}  // namespace takt::capture
