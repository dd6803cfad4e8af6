// Frames told in words. Beside the rest of the room (target takt::wire_words): text needs the heap.
#pragma once

#include <string>

#include "takt/base/engine.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::wire {

/// "unit 16 read holding registers 500..501", "unit 1 write single coil 7 = on". Addresses are zero-based.
/// Never fails: what cannot be read is shown as hex, with the reason.
std::string describe_request(UnitId unit, Bytes pdu);

/// "unit 16 read holding registers → 2 values: 0 16256"; with the request known
/// "unit 16 read holding registers 500..501 → 2 values: 0 16256". Of many values the first 32. Never fails:
/// what cannot be read, or is no answer to the request, is shown as hex, with the reason.
std::string describe_response(UnitId unit, Bytes pdu, const Request* request = nullptr);

/// "10 03 00 00" — upper case, separated by blanks.
std::string hex(Bytes bytes);

}  // namespace takt::wire
