// How long an RTU frame will be, told from its beginning.
#pragma once

#include <cstddef>

#include "takt/base/engine.hpp"

namespace takt::wire {

/// Bytes of the whole frame (address, PDU, CRC) that begins with `frame`, read as a request or as a response.
/// 0 while too few bytes are there, where the function tells no length, and where the beginning cannot be
/// one.
std::size_t foretold_request_length(Bytes frame);
std::size_t foretold_response_length(Bytes frame);

}  // namespace takt::wire
