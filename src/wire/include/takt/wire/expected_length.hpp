// The length of an RTU frame, derived from its first bytes.
#pragma once

#include <cstddef>

#include "takt/base/engine.hpp"

namespace takt::wire {

/// The length of the frame (address, PDU, CRC) that starts with the bytes of `frame`, taken as a request or
/// as a response. 0 while there are too few bytes, if the function does not define a length, and if no such
/// frame can start so.
std::size_t expected_request_length(Bytes frame);
std::size_t expected_response_length(Bytes frame);

}  // namespace takt::wire
