// One frame of a serial line: its checks, unit and PDU.
#pragma once

#include "takt/base/engine.hpp"
#include "takt/base/inplace_vector.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::capture {

/// Unit and PDU; empty: damaged.
using SerialFrame = InplaceVector<std::uint8_t, 2 + wire::kMaxPdu>;

/// Decodes an RTU frame with its CRC.
[[nodiscard]] SerialFrame decode_rtu(Bytes frame);

/// Decodes an ASCII frame, from ':' to CR LF.
[[nodiscard]] SerialFrame decode_ascii(Bytes frame);

/// Decodes a frame of either framing: ASCII if it begins and ends so.
[[nodiscard]] SerialFrame decode_serial(Bytes frame);

}  // namespace takt::capture
