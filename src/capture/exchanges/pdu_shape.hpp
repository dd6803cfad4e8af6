// Whether bytes can be a request or a response, from their own length fields.
#pragma once

#include <optional>

#include "takt/base/engine.hpp"
#include "takt/wire/frame.hpp"

namespace takt::capture {

/// @param pdu  1..253 bytes
[[nodiscard]] bool could_be_request(Bytes pdu);
[[nodiscard]] bool could_be_response(Bytes pdu);

/// Whether the bytes are one RTU or ASCII frame, by its checksum and its PDU.
/// @returns the framing
[[nodiscard]] std::optional<wire::Framing> serial_framing_of(Bytes bytes);

}  // namespace takt::capture
