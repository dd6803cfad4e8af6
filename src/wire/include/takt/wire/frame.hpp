// Application data units: a PDU with its address and checks, in the three framings.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "takt/base/engine.hpp"
#include "takt/base/inplace_vector.hpp"
#include "takt/base/numbers.hpp"
#include "takt/wire/function.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::wire {

/// rtu: address, PDU, CRC-16. ascii: ':', hex, LRC, CR LF. tcp: MBAP header, PDU.
enum class Framing : std::uint8_t { rtu, ascii, tcp };

/// "rtu", "ascii", "tcp".
std::string_view name(Framing framing);

inline constexpr std::size_t kMaxRtuFrame = 256;
inline constexpr std::size_t kMaxAsciiFrame = 513;
inline constexpr std::size_t kMaxTcpFrame = 260;

/// Long enough for a frame of any framing.
using FrameBytes = InplaceVector<std::uint8_t, kMaxAsciiFrame>;

/// The parts of a frame. `pdu` points into the buffer of the framer that returned it.
struct Frame {
    UnitId unit;
    std::uint16_t transaction = 0;  ///< tcp only
    Bytes pdu;
};

/// CRC-16/Modbus (polynomial 0xA001 reflected, start 0xFFFF); low byte first on the wire.
std::uint16_t crc16(Bytes bytes);

/// Longitudinal redundancy check of ASCII: two's complement of the sum.
std::uint8_t lrc(Bytes bytes);

/// The frame as bytes on the wire (ASCII: characters). 1 <= pdu.size() <= 253.
FrameBytes encode_frame(Framing framing, UnitId unit, std::uint16_t transaction, Bytes pdu);

/// Characters (bytes) of a frame with a PDU of that length: RTU 3 + n, ASCII 2 (n + 2) + 3, TCP 7 + n.
constexpr std::size_t frame_length(Framing framing, std::size_t pdu_length) {
    switch (framing) {
        case Framing::rtu: return pdu_length + 3;
        case Framing::ascii: return 2 * (pdu_length + 2) + 3;
        case Framing::tcp: return pdu_length + 7;
    }
    return 0;
}

/// Bytes of the request and of the normal response PDU for `quantity` items of a read or write function
/// (0x01..0x06, 0x0F, 0x10, 0x16; for 0x17 `quantity` is read, `written` is written).
std::size_t request_pdu_length(Function function, std::size_t quantity, std::size_t written = 0);
std::size_t response_pdu_length(Function function, std::size_t quantity);

/// Limits of a controller, in addition to those of the protocol (docs/specification.md, section 3).
struct FrameLimits {
    /// Characters of a frame, request or response; 0: the framing's own maximum.
    std::size_t frame_buffer = 0;
    /// Items of any request; 0: the specification's.
    std::size_t max_items = 0;
    friend constexpr bool operator==(FrameLimits, FrameLimits) = default;
};

/// The greatest number of items in one request of `function`. The request and the response PDU fit into 253
/// bytes, their frames fit into the buffer, and neither the quantity of the protocol nor `max_items` is
/// exceeded. 1 for 0x05, 0x06, 0x16; 0 for functions without items.
std::size_t max_items(Framing framing, Function function, const FrameLimits& limits = {});

}  // namespace takt::wire
