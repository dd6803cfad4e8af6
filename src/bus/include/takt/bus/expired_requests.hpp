// Requests that ended without their response, so that a late response is recognised and its delay measured.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "takt/base/inplace_vector.hpp"
#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/bus/transaction.hpp"

namespace takt::bus {

/// A response that was received after its transaction had ended.
struct LateResponse {
    UnitId unit;
    std::uint8_t function = 0;  ///< of the request
    Instant at;                 ///< its last byte
    /// From the end of the request to the first byte of the response. If the unit answered an earlier request
    /// meanwhile, from that answer on: a device that works on one request at a time had not begun before.
    Duration delay{};
    Duration wait{};  ///< Transaction::wait of the request
    friend bool operator==(const LateResponse&, const LateResponse&) = default;
};

/// A time-out for a device that answers after `delay`: at least a fifth longer, rounded up to 1, 1.5, 2, 3,
/// 4, 5, 6 or 8 times a power of ten in milliseconds; at most 65535 ms.
[[nodiscard]] Duration advised_timeout(Duration delay);

/// The last kCapacity requests that ended without a response, each for kRemembered.
///
/// Over Framing::tcp the transaction id identifies the request. On a serial line it is the oldest one whose
/// response has the received shape. LateAnswers decides which requests must wait; this class only measures.
/// Never allocates; one owner, one thread.
class ExpiredRequests {
public:
    static constexpr std::size_t kCapacity = 8;
    static constexpr Duration kRemembered = std::chrono::seconds(10);

    struct Request {
        UnitId unit;
        AnswerShape shape;
        std::uint16_t wire_id = 0;  ///< Framing::tcp
        Instant end;                ///< of the request, or of the last answer of the unit before its own
        Instant expired_at;
        Duration wait{};
    };

    /// A request ended without a response. If there is no memory left, the oldest one is forgotten.
    void add(const Request& request);

    /// Whether a response with this transaction id may still come.
    [[nodiscard]] bool expects(std::uint16_t wire_id) const;

    /// A frame was received that answers no request in flight.
    /// @param wire_id  nothing: the line is serial
    /// @param begin    its first byte
    /// @returns whether it is a late response; take() then gives it
    [[nodiscard]] bool settle(UnitId unit, Bytes pdu, std::optional<std::uint16_t> wire_id, Instant begin,
                              Instant end);

    /// Serial line: a request in flight got a response. If one of that shape is still owed, the response may
    /// be that one; then the response to this request is owed now.
    void note_response(UnitId unit, const AnswerShape& shape, Instant request_end, Duration wait);

    /// The late responses that were not taken yet, in the order of their requests.
    [[nodiscard]] std::optional<LateResponse> take();

    void clear() { requests_.clear(); }

private:
    struct Entry {
        Request request;
        std::optional<LateResponse> late;
    };
    InplaceVector<Entry, kCapacity> requests_;
};

}  // namespace takt::bus
