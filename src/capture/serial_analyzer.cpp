#include "takt/capture/serial_analyzer.hpp"

#include <algorithm>

#include "pdu_shape.hpp"
#include "takt/base/inplace_vector.hpp"
#include "takt/capture/upper_pdu.hpp"
#include "takt/wire/frame.hpp"

namespace takt::capture {
namespace {

constexpr std::size_t kRtacHeader = 12;
constexpr std::size_t kRtacEvent = 8;          // position of the event's type
constexpr std::uint8_t kFirstErrorOfRtac = 7;  // framing, parity, break, overflow
constexpr std::uint8_t kDataLostOfRtac = 5;
constexpr std::size_t kLeastRtu = 4;
constexpr std::size_t kMostDecoded = 2 + wire::kMaxPdu;

using Decoded = InplaceVector<std::uint8_t, kMostDecoded>;  // unit and PDU

int digit(std::uint8_t character) {
    if (character >= '0' && character <= '9') return character - '0';
    if (character >= 'A' && character <= 'F') return character - 'A' + 10;
    if (character >= 'a' && character <= 'f') return character - 'a' + 10;
    return -1;
}

/// Unit and PDU of ":…CR LF"; empty: damaged.
Decoded decode_ascii(Bytes frame) {
    Decoded bytes;
    const auto digits = frame.subspan(1, frame.size() - 3);
    if (digits.size() % 2 != 0 || digits.size() / 2 > bytes.capacity()) return {};
    for (std::size_t i = 0; i < digits.size(); i += 2) {
        const int high = digit(digits[i]);
        const int low = digit(digits[i + 1]);
        if (high < 0 || low < 0) return {};
        bytes.push_back(static_cast<std::uint8_t>(high * 16 + low));
    }
    if (bytes.size() < 3 || wire::lrc({bytes.data(), bytes.size() - 1}) != bytes.back()) return {};
    bytes.pop_back();
    return bytes;
}

Decoded decode_rtu(Bytes frame) {
    Decoded bytes;
    if (frame.size() < kLeastRtu || frame.size() > wire::kMaxRtuFrame) return {};
    const auto body = frame.first(frame.size() - 2);
    const auto sum = static_cast<std::uint16_t>(frame[body.size()] | frame[body.size() + 1] << 8U);
    if (wire::crc16(body) == sum) bytes.assign(body);
    return bytes;
}

Decoded decode(Bytes frame) {
    const bool is_ascii = frame.size() >= 9 && frame[0] == ':' && frame[frame.size() - 2] == '\r' &&
                          frame[frame.size() - 1] == '\n';
    return is_ascii ? decode_ascii(frame) : decode_rtu(frame);
}

PacketRef ref_of(const Packet& packet) {
    return {packet.number, packet.time_ns};
}

}  // namespace

bool SerialAnalyzer::is_serial(LinkType link) {
    return link == LinkType::rtac_serial || link == LinkType::upper_pdu ||
           (link >= LinkType::user_0 && link <= LinkType::user_15);
}

void SerialAnalyzer::on_packet(const Packet& packet) {
    auto& line = lines_[packet.interface];
    if (packet.link == LinkType::upper_pdu) return on_upper_pdu(line, packet);
    if (packet.link != LinkType::rtac_serial) return on_frame(line, packet, packet.data);
    if (packet.data.size() <= kRtacEvent) return;
    const auto event = packet.data[kRtacEvent];
    if (event >= kFirstErrorOfRtac || event == kDataLostOfRtac) ++counts_.line_errors;
    if (packet.data.size() > kRtacHeader) on_frame(line, packet, packet.data.subspan(kRtacHeader));
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
    const auto decoded = decode(frame);
    if (decoded.size() < 2) {
        ++counts_.damaged;
        return;
    }
    on_pdu(line, packet, decoded[0], Bytes(decoded.data(), decoded.size()).subspan(1));
}

bool SerialAnalyzer::answers(const Line& line, const Packet& packet, std::uint8_t unit, Bytes pdu) const {
    if (!line.waits || line.request.unit != unit) return false;
    if (!wire::decode_response(line.bytes.shape(), line.bytes.pdu(), pdu)) return false;
    const bool same = std::ranges::equal(line.bytes.pdu(), pdu);
    return !same || packet.time_ns - line.request.packet.time_ns <= timeout_.count();
}

void SerialAnalyzer::on_pdu(Line& line, const Packet& packet, std::uint8_t unit, Bytes pdu) {
    if (answers(line, packet, unit, pdu)) {
        line.waits = false;
        const bool is_exception = wire::is_exception(pdu[0]) && pdu.size() > 1;
        sink_.on_response(line.request,
                          {.packet = ref_of(packet), .exception = is_exception ? pdu[1] : std::uint8_t{0}});
    } else if (wire::is_exception(pdu[0]) || (!could_be_request(pdu) && could_be_response(pdu))) {
        ++counts_.unmatched;
    } else {
        on_request(line, packet, unit, pdu);
    }
}

void SerialAnalyzer::on_request(Line& line, const Packet& packet, std::uint8_t unit, Bytes pdu) {
    if (line.waits) sink_.on_no_response(line.request, NoResponse::unanswered);
    line.request = {.route = {.serial = true, .interface = packet.interface},
                    .unit = unit,
                    .function = pdu[0],
                    .items = items_of(pdu),
                    .packet = ref_of(packet)};
    sink_.on_request(line.request);
    line.waits = unit != kBroadcast.value;
    if (line.waits)
        line.bytes = wire::PreparedRequest(pdu);
    else
        sink_.on_no_response(line.request, NoResponse::broadcast);
}

void SerialAnalyzer::end() {
    for (auto& [interface, line] : lines_)
        if (line.waits) sink_.on_no_response(line.request, NoResponse::end);
    lines_.clear();
}

}  // namespace takt::capture
