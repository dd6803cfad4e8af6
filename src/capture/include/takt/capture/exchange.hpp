// Requests and responses found in a capture.
#pragma once

#include <cstdint>

#include "takt/capture/packet.hpp"
#include "takt/capture/segment.hpp"

namespace takt::capture {

/// The two endpoints of a request, or its serial line.
struct Route {
    bool serial = false;          ///< on a serial line: the endpoints are empty
    std::uint32_t interface = 0;  ///< serial: the interface of the capture; else 0
    Endpoint client;
    Endpoint server;
    friend constexpr bool operator==(const Route&, const Route&) = default;
};

/// A request as it was seen.
struct ObservedRequest {
    Route route;
    std::uint16_t transaction = 0;  ///< 0 on a serial line
    std::uint8_t unit = 0;
    std::uint8_t function = 0;
    /// Equal for requests that a master repeats periodically: the address, and the quantity where there is
    /// one.
    std::uint32_t items = 0;
    PacketRef packet;  ///< the one with its last byte
};

/// The response to it.
struct ObservedResponse {
    PacketRef packet;            ///< the one with its last byte, as modbus.response_time of Wireshark
    std::uint8_t exception = 0;  ///< the code; 0: a normal response
    /// Segments of the connection that were sent again, whole or in part, between request and response, in
    /// either direction.
    std::uint64_t retransmissions = 0;
};

/// Why there is no response to a request.
enum class NoResponse : std::uint8_t {
    unanswered,  ///< the connection ended; on a serial line as of SerialPairing
    end,         ///< the capture ended
    broadcast,   ///< none is sent
};

/// Receives what is found. Each request is reported by on_request(), and later by one of the other two.
class ExchangeSink {
public:
    virtual void on_request(const ObservedRequest& request) = 0;
    virtual void on_response(const ObservedRequest& request, const ObservedResponse& response) = 0;
    virtual void on_no_response(const ObservedRequest& request, NoResponse why) = 0;

protected:
    ~ExchangeSink() = default;
};

/// ObservedRequest::items of a request PDU.
[[nodiscard]] std::uint32_t items_of(Bytes pdu);

}  // namespace takt::capture
