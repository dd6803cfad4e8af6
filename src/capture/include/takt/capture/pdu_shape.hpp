// Whether bytes can be a request or a response, from their own length fields.
#pragma once

#include "takt/base/engine.hpp"

namespace takt::capture {

/// @param pdu  1..253 bytes
[[nodiscard]] bool could_be_request(Bytes pdu);
[[nodiscard]] bool could_be_response(Bytes pdu);

}  // namespace takt::capture
