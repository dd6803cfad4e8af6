#include "takt/capture/serial_packet.hpp"

#include <algorithm>
#include <string_view>

#include "network/mbap_stream.hpp"
#include "network/upper_pdu.hpp"
#include "serial/serial_frame.hpp"
#include "takt/base/ascii.hpp"
#include "takt/capture/frame_capture.hpp"
#include "takt/capture/segment.hpp"
#include "takt/capture/serial_analyzer.hpp"

namespace takt::capture {
namespace {

std::optional<unsigned> upper_hex_value(char c) {
    return lower_case(c) == c && !is_digit(c) ? std::nullopt : hex_value(c);
}

/// "10 03 00"; empty: it is no such text.
wire::FrameBytes bytes_of_hex(std::string_view text) {
    wire::FrameBytes bytes;
    for (std::size_t at = 0; at < text.size(); at += 3) {
        const bool separated = at == 0 || text[at - 1] == ' ';
        const auto high = upper_hex_value(text[at]);
        const auto low = at + 1 < text.size() ? upper_hex_value(text[at + 1]) : std::nullopt;
        if (!separated || !high || !low || bytes.full()) return {};
        bytes.push_back(static_cast<std::uint8_t>(*high << 4U | *low));
    }
    return bytes;
}

/// The frame in the comment of a packet.
wire::FrameBytes frame_of_comment(std::string_view comment) {
    const auto bar = comment.rfind(FrameCapture::kCommentSeparator);
    if (bar != std::string_view::npos) comment.remove_prefix(bar + FrameCapture::kCommentSeparator.size());
    if (!comment.starts_with(':')) return bytes_of_hex(comment);
    wire::FrameBytes bytes;
    if (comment.size() + 2 > bytes.capacity()) return {};
    bytes.append({reinterpret_cast<const std::uint8_t*>(comment.data()), comment.size()});
    bytes.push_back('\r');
    bytes.push_back('\n');
    return bytes;
}

}  // namespace

SerialPacket::SerialPacket(const Packet& packet) {
    if (packet.link == LinkType::upper_pdu) {
        read_upper_pdu(packet);
    } else if (packet.link == LinkType::raw) {
        read_segment(packet);
    } else if (SerialAnalyzer::is_serial(packet.link)) {
        bytes_ = SerialAnalyzer::frame_of(packet);
        kind_ = bytes_.empty() ? Kind::none : Kind::frame;
    }
}

void SerialPacket::read_upper_pdu(const Packet& packet) {
    const auto upper = decode_upper_pdu(packet.data);
    if (!upper || upper->payload.empty()) return;
    if (upper->dissector == kRtuDissector) kind_ = Kind::frame;
    if (upper->dissector == kDataDissector) kind_ = Kind::damaged;
    if (kind_ != Kind::none) bytes_ = upper->payload;
}

void SerialPacket::read_segment(const Packet& packet) {
    if (packet.comment.empty()) return;
    Segment segment;
    Fragment fragment;
    if (decode_segment(packet, segment, fragment) != Content::segment) return;
    if (segment.payload.size() <= kMbapHeaderBytes) return;
    decoded_ = frame_of_comment(packet.comment);
    const auto frame = decode_serial(decoded_.span());
    if (frame.empty() || !std::ranges::equal(frame, segment.payload.subspan(kMbapUnitAt)))
        return decoded_.clear();
    kind_ = Kind::frame;
    if (segment.destination.port == FrameCapture::kServerPort) sender_ = Sender::master;
    if (segment.source.port == FrameCapture::kServerPort) sender_ = Sender::slave;
}

}  // namespace takt::capture
