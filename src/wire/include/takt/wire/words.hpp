// Descriptions of frames in words. A target of its own (takt::wire_words), because text needs the heap.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "takt/base/engine.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/pdu.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::wire {

/// "unit 16 read holding registers 500..501", "unit 1 write single coil 7 = on". Addresses are zero-based.
/// Never fails: a PDU that cannot be decoded is shown as hex, with the reason.
std::string describe_request(UnitId unit, Bytes pdu);

/// The same for a PDU that the caller has decoded.
std::string describe_request(UnitId unit, Bytes pdu, const Result<Request>& request);

/// "unit 16 read holding registers → 2 values: 0 16256"; with the request known
/// "unit 16 read holding registers 500..501 → 2 values: 0 16256". Of many values the first 32. Never fails:
/// a PDU that cannot be decoded, or does not answer the request, is shown as hex, with the reason.
std::string describe_response(UnitId unit, Bytes pdu, const Request* request = nullptr);

/// "no response within 500 ms", "late response: late by 12 ms", "surplus response: a response of unit 1 came,
/// unit 5 was asked".
std::string describe_incident(Incident incident, Duration after, const std::optional<Mismatch>& instead);

/// Describes the frames of one line: a response with the addresses of the last request to its unit.
class FrameWords {
public:
    std::string request(UnitId unit, Bytes pdu);
    std::string response(UnitId unit, Bytes pdu) const;

private:
    std::map<std::uint8_t, Request> requests_;  // the last one to each address
};

/// "10 03 00 00" — upper case, separated by blanks.
std::string hex(Bytes bytes);

}  // namespace takt::wire
