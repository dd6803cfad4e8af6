// A transaction, its outcome, and the settings of a line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/broadcast.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/line_timing.hpp"
#include "takt/wire/prepared_request.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::bus {

/// Whether the master receives its own requests (two-wire adapters that leave their receiver on).
enum class Echo : std::uint8_t {
    automatic,  ///< detected; an echo is dropped
    untimed,    ///< a pseudo-terminal: bytes take no time, so the time of a repetition proves nothing
    absent,     ///< never: sockets
};

/// Settings of one line or connection.
struct LineConfig {
    wire::Framing framing = wire::Framing::rtu;
    wire::CharacterFormat
        format;              ///< baud 0: a byte stream (RTU or ASCII over TCP); ignored for Framing::tcp
    Duration frame_gap{};    ///< the least silence before a request, if longer than t3.5
    Duration request_gap{};  ///< least time from the start of one request to the start of the next
    Duration margin = std::chrono::milliseconds(2);  ///< added to every deadline
    /// The silence after a broadcast.
    Duration broadcast_turnaround = wire::kBroadcastTurnaround;
    /// RTU: the pause that ends a received frame, and after which bytes with a wrong CRC are dropped. The
    /// length of a response is known, so no response waits for it. Zero: the longer of 30 ms and t3.5,
    /// because adapters deliver bytes in bursts; over a stream 50 ms. ASCII: the longest pause between two
    /// characters; zero: 1 s.
    Duration frame_silence{};
    std::size_t in_flight = 1;       ///< Framing::tcp: transactions at a time, 1..kMaxInFlight
    bool length_tolerance = false;   ///< Framing::tcp, one at a time: wire::FramerConfig
    Duration pause_after_connect{};  ///< least time from the link's opening to the first request
    Echo echo = Echo::automatic;
    std::uint16_t first_transaction = 1;  ///< Framing::tcp: where TransactionIds begin

    /// Whether characters take time, unlike in a byte stream.
    [[nodiscard]] bool is_serial() const { return framing != wire::Framing::tcp && format.baud != 0; }
    /// The time that so many characters take on the line; zero over a stream.
    [[nodiscard]] Duration characters_time(std::size_t characters) const;
    /// The time that the frame of a PDU of that length takes on the line.
    [[nodiscard]] Duration frame_time(std::size_t pdu_length) const {
        return characters_time(wire::frame_length(framing, pdu_length));
    }
    /// The least silence before a request: max(t3.5, frame_gap) for RTU on a serial line, else frame_gap.
    [[nodiscard]] Duration silence_before_request() const;
};

inline constexpr std::size_t kMaxInFlight = 16;

/// Chosen by the caller and returned with the outcome.
using TransactionId = std::uint64_t;

/// One request and how long to wait for its response.
struct Transaction {
    TransactionId id = 0;
    UnitId unit{1};
    wire::PreparedRequest request;  ///< 1..253 bytes; any function, also unknown ones
    /// The longest time from the end of the request to the first byte of the response: the turnaround if it
    /// is known, else the response time-out. The deadline is the end of the request + this (RTU on a serial
    /// line: at least t3.5) + the length of the response + LineConfig::margin.
    Duration wait = std::chrono::milliseconds(100);
    /// How long after the deadline a late response may still arrive (docs/guarantees.md, "Late responses");
    /// default: `wait`.
    std::optional<Duration> late_limit;
    /// How late late responses of the unit usually are. Zero: not known.
    Duration lateness{};
    /// If the response is late, nothing is sent to the unit until so long after the end of the request: it
    /// usually comes by then. Ends with the first response that looks like it. Zero: does not wait.
    Duration patience{};
    /// The longest time from a request to the first byte of its response that was seen, at most `wait`;
    /// default: `wait`.
    std::optional<Duration> longest_delay;
    bool in_order = true;  ///< the unit answers requests in their order, as far as is known
};

enum class Status : std::uint8_t {
    ok,                ///< the normal response; of a broadcast: it was sent and its turnaround has passed
    exception,         ///< the device answered with an exception
    timeout,           ///< no response by the deadline
    bad_checksum,      ///< bytes were received, but no frame with a good checksum, or only the begin of one
    unexpected_reply,  ///< a good frame of the right unit and function that cannot answer this request
    ambiguous,  ///< serial line: the response may be that to an earlier request. Its unit is in step again
    link_lost,  ///< the port or connection was lost, or closed while several requests waited for a response
    closed,     ///< the peer closed the connection while only this request waited for a response
    line_busy,  ///< never sent: for more than a second the line was never silent
    cancelled,  ///< cancel_all()
};
std::string_view name(Status status);

/// How a transaction ended. Every accepted transaction has exactly one.
struct Outcome {
    TransactionId id = 0;
    UnitId unit{1};
    Status status = Status::ok;
    std::uint8_t exception = 0;  ///< the code as received, any byte
    bool sent = false;  ///< its bytes were given to the line; without a response a write may have executed
    /// Framing::tcp: the connection ends with it: it is not known where the next response begins.
    bool out_of_step = false;
    std::uint16_t wire_id = 0;  ///< Framing::tcp: its transaction id on the wire, if it was sent; else 0
    /// What was received instead of the response, and is why there is none. Status::timeout: the response of
    /// another unit or function that would answer this request (serial line: none where another master sent
    /// a request meanwhile; Framing::tcp: also one with another transaction id). Status::bad_checksum: only
    /// the begin of the response came (Mismatch::Part::length).
    std::optional<Mismatch> instead;
    /// Bytes of noise that were received between the request and its response.
    std::uint32_t noise = 0;
    wire::RequestShape request;
    Duration wait{};  ///< Transaction::wait
    /// Empty without a response. Points into the engine's buffers: valid until the next submit().
    wire::ResponseView response;
    Instant sent_at;      ///< start of the request
    Instant request_end;  ///< end of its last character, computed
    Instant ended_at;     ///< last byte of the response, or when the engine gave up
    /// After a response: a further one of the unit that nothing holds back would be complete by then.
    Instant quiet_at;
};

/// The properties that identify a response on a serial line. A frame carries nothing else of its request.
struct AnswerShape {
    std::uint8_t function = 0;
    std::uint16_t pdu_length = 0;  ///< of the normal response; 0: the request does not fix it
    friend bool operator==(const AnswerShape&, const AnswerShape&) = default;
};

/// The shape of the normal response to a request.
constexpr AnswerShape answer_shape(const wire::RequestShape& request) {
    const std::size_t length = request.fixed_length ? request.response_length : 0;
    return {request.function, static_cast<std::uint16_t>(length)};
}
/// Of a read or a write of so many items.
inline AnswerShape answer_shape(wire::Function function, std::size_t quantity) {
    return {static_cast<std::uint8_t>(function),
            static_cast<std::uint16_t>(wire::response_pdu_length(function, quantity))};
}

}  // namespace takt::bus
