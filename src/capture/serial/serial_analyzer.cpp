#include "takt/capture/serial_analyzer.hpp"

#include "network/upper_pdu.hpp"
#include "serial/serial_frame.hpp"

namespace takt::capture {
namespace {

constexpr std::size_t kRtacHeader = 12;
constexpr std::size_t kRtacEvent = 8;          // position of the event's type
constexpr std::uint8_t kFirstErrorOfRtac = 7;  // framing, parity, break, overflow
constexpr std::uint8_t kDataLostOfRtac = 5;

PacketRef ref_of(const Packet& packet) {
    return {packet.number, packet.time_ns};
}

}  // namespace

bool SerialAnalyzer::is_serial(LinkType link) {
    return link == LinkType::rtac_serial || link == LinkType::upper_pdu ||
           (link >= LinkType::user_0 && link <= LinkType::user_15);
}

SerialAnalyzer::Line& SerialAnalyzer::line_of(std::uint32_t interface) {
    return lines_.try_emplace(interface, timeout_).first->second;
}

Bytes SerialAnalyzer::frame_of(const Packet& packet) {
    if (packet.link != LinkType::rtac_serial) return packet.data;
    return packet.data.size() > kRtacHeader ? packet.data.subspan(kRtacHeader) : Bytes{};
}

void SerialAnalyzer::on_packet(const Packet& packet) {
    auto& line = line_of(packet.interface);
    if (packet.link == LinkType::upper_pdu) return on_upper_pdu(line, packet);
    const bool is_rtac = packet.link == LinkType::rtac_serial;
    if (is_rtac && packet.data.size() > kRtacEvent) {
        const auto event = packet.data[kRtacEvent];
        if (event >= kFirstErrorOfRtac || event == kDataLostOfRtac) ++counts_.line_errors;
    }
    const auto frame = frame_of(packet);
    if (!is_rtac || !frame.empty()) on_frame(line, packet, frame);
}

void SerialAnalyzer::on_upper_pdu(Line& line, const Packet& packet) {
    const auto upper = decode_upper_pdu(packet.data);
    if (!upper) return;
    if (upper->dissector == kRtuDissector) return on_frame(line, packet, upper->payload);
    if (upper->dissector != kDataDissector) return;
    ++counts_.frames;
    ++counts_.damaged;
}

void SerialAnalyzer::on_frame(Line& line, const Packet& packet, Bytes frame) {
    ++counts_.frames;
    const auto decoded = decode_serial(frame);
    if (decoded.size() < 2) {
        ++counts_.damaged;
        return;
    }
    const auto pdu = decoded.span().subspan(1);
    const auto outcome = line.pairing.on_frame(packet.time_ns, decoded[0], pdu);
    give_up(line, outcome.given_up, NoResponse::unanswered);
    auto& request = line.requests[outcome.slot];
    switch (outcome.role) {
        case SerialPairing::Role::stray: ++counts_.unmatched; break;
        case SerialPairing::Role::response:
            sink_.on_response(
                request,
                {.packet = ref_of(packet),
                 .exception = wire::is_exception(pdu[0]) && pdu.size() > 1 ? pdu[1] : std::uint8_t{0}});
            break;
        case SerialPairing::Role::request:
        case SerialPairing::Role::broadcast:
            request = {.route = {.serial = true, .interface = packet.interface},
                       .unit = decoded[0],
                       .function = pdu[0],
                       .items = items_of(pdu),
                       .packet = ref_of(packet)};
            sink_.on_request(request);
            if (outcome.role == SerialPairing::Role::broadcast)
                sink_.on_no_response(request, NoResponse::broadcast);
            break;
    }
}

void SerialAnalyzer::give_up(const Line& line, const SerialPairing::Slots& slots, NoResponse why) {
    for (const auto slot : slots) sink_.on_no_response(line.requests[slot], why);
}

void SerialAnalyzer::end() {
    for (auto& [interface, line] : lines_) give_up(line, line.pairing.end(), NoResponse::end);
    lines_.clear();
}

}  // namespace takt::capture
