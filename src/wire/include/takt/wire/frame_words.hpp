// Descriptions of frames in words. A target of its own (takt::wire_words), because text needs the heap.
#pragma once

#include <cstdint>
#include <deque>
#include <string>

#include "takt/wire/frame.hpp"
#include "takt/wire/pdu.hpp"

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

/// Describes the frames of one line: a response with the addresses of its request. That is the one with its
/// transaction id over TCP, else the last one to its unit. A response that does not answer it has no
/// addresses.
class FrameWords {
public:
    /// @param raw  as on the wire: it has the transaction id
    std::string request(UnitId unit, Bytes pdu, Bytes raw);
    std::string response(UnitId unit, Bytes pdu, Bytes raw) const;

private:
    static constexpr std::size_t kMost = 256;

    struct Sent {
        UnitId unit;
        std::uint16_t id = 0;
        Request request;
    };
    std::deque<Sent> requests_;  // at most kMost, the last one at the end
};

/// "10 03 00 00" — upper case, separated by blanks.
std::string hex(Bytes bytes);

}  // namespace takt::wire
