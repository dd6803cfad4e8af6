#include "takt/wire/frame.hpp"

#include "takt/base/ascii.hpp"
#include "takt/base/assert.hpp"

namespace takt::wire {
namespace {

void append_u16(FrameBytes& frame, std::size_t value) {
    frame.push_back(static_cast<std::uint8_t>(value >> 8));
    frame.push_back(static_cast<std::uint8_t>(value));
}

void append_hex(FrameBytes& frame, std::uint8_t byte) {
    frame.push_back(static_cast<std::uint8_t>(hex_digit(byte >> 4U)));
    frame.push_back(static_cast<std::uint8_t>(hex_digit(byte)));
}

FrameBytes encode_rtu(UnitId unit, Bytes pdu) {
    FrameBytes frame{unit.value};
    frame.append(pdu);
    const std::uint16_t crc = crc16(frame.span());
    frame.push_back(static_cast<std::uint8_t>(crc));
    frame.push_back(static_cast<std::uint8_t>(crc >> 8));
    return frame;
}

FrameBytes encode_ascii(UnitId unit, Bytes pdu) {
    FrameBytes frame{':'};
    append_hex(frame, unit.value);
    for (const std::uint8_t byte : pdu) append_hex(frame, byte);
    append_hex(frame, static_cast<std::uint8_t>(lrc(pdu) - unit.value));
    frame.push_back('\r');
    frame.push_back('\n');
    return frame;
}

FrameBytes encode_tcp(UnitId unit, std::uint16_t transaction, Bytes pdu) {
    FrameBytes frame;
    append_u16(frame, transaction);
    append_u16(frame, 0);
    append_u16(frame, pdu.size() + 1);
    frame.push_back(unit.value);
    frame.append(pdu);
    return frame;
}

}  // namespace

std::string_view name(Framing framing) {
    switch (framing) {
        case Framing::rtu: return "rtu";
        case Framing::ascii: return "ascii";
        case Framing::tcp: return "tcp";
    }
    return "framing";
}

FrameBytes encode_frame(Framing framing, UnitId unit, std::uint16_t transaction, Bytes pdu) {
    TAKT_ASSERT(!pdu.empty() && pdu.size() <= kMaxPdu);
    switch (framing) {
        case Framing::rtu: return encode_rtu(unit, pdu);
        case Framing::ascii: return encode_ascii(unit, pdu);
        case Framing::tcp: return encode_tcp(unit, transaction, pdu);
    }
    return {};
}

}  // namespace takt::wire
