// What goes over a line: a transaction, its outcome, and the settings of the line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/line_timing.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::bus {

/// Whether the master may hear its own requests.
enum class Echo : std::uint8_t {
    automatic,  ///< found out; an echo is dropped where it appears
    untimed,    ///< a pseudo-terminal: bytes take no time there, so the time of a repetition proves nothing
    absent,     ///< known not to happen: sockets
};

/// Settings of one line or connection.
struct LineConfig {
    wire::Framing framing = wire::Framing::rtu;
    wire::CharacterFormat
        format;            ///< baud 0: a byte stream (RTU or ASCII over TCP); of no account for Framing::tcp
    Duration frame_gap{};  ///< least silence before a request, where more than t3.5
    Duration request_gap{};  ///< least time from the start of one request to the start of the next
    Duration margin = std::chrono::milliseconds(2);  ///< added to every deadline
    /// After a broadcast nothing is sent for this long (MODBUS over Serial Line V1.02, section 2.4.1:
    /// 100..200 ms).
    Duration broadcast_turnaround = std::chrono::milliseconds(100);
    /// RTU: pause after which received bytes are taken as a whole, and bytes that do not check are given up.
    /// A response's length is foretold, so this delays none. Zero: 30 ms, or t3.5 where that is longer, so
    /// that an adapter may deliver in lumps; over a stream 50 ms.
    /// ASCII: the longest pause between two characters; zero: 1 s.
    Duration frame_silence{};
    std::size_t in_flight = 1;  ///< Framing::tcp: transactions at a time, 1..kMaxInFlight
    Echo echo = Echo::automatic;

    /// Characters with times, as opposed to a byte stream.
    [[nodiscard]] bool is_serial() const { return framing != wire::Framing::tcp && format.baud != 0; }
};

inline constexpr std::size_t kMaxInFlight = 16;

/// Chosen by the caller; only handed back.
using TransactionId = std::uint64_t;

/// One request and how long to wait for its response.
struct Transaction {
    TransactionId id = 0;
    UnitId unit{1};
    wire::PreparedRequest request;  ///< 1..253 bytes; any function, also unknown ones
    /// Longest time from the end of the request to the first byte of the response: the turnaround where it is
    /// known, else the response timeout. The one deadline is: end of request + this (RTU on a serial line: at
    /// least t3.5) + length of the response + margin.
    Duration wait = std::chrono::milliseconds(100);
    /// How late beyond its deadline an answer may still come (docs/guarantees.md, "Late responses"); nothing:
    /// as long as `wait`.
    std::optional<Duration> late_limit;
};

enum class Status : std::uint8_t {
    ok,                ///< the normal response; for a broadcast: sent, and its turnaround is over
    exception,         ///< the device says no
    timeout,           ///< no answer by the deadline
    bad_checksum,      ///< bytes came, but no frame that checks
    unexpected_reply,  ///< unit, function and checksum fit, but it is no answer to this request
    link_lost,         ///< the port or connection went away
    line_busy,         ///< never sent: others kept the line from falling silent for longer than a second
    cancelled,         ///< cancel_all()
};
std::string_view name(Status status);

/// How a transaction ended. Every accepted transaction has exactly one.
struct Outcome {
    TransactionId id = 0;
    UnitId unit{1};
    Status status = Status::ok;
    std::uint8_t exception = 0;  ///< the code as received, any byte
    bool sent = false;  ///< its bytes were handed to the line: without a response a write may have been done
    /// Empty without a response. Points into the engine's buffers: valid until the next submit().
    wire::ResponseView response;
    Instant sent_at;     ///< start of the request
    Instant request_end;  ///< end of its last character, computed
    Instant ended_at;     ///< last byte of the response, or when the transaction was given up
};

/// What an answer on a serial line can be told by: all that the frame itself says.
struct AnswerShape {
    std::uint8_t function = 0;
    std::size_t pdu_length = 0;  ///< of the normal response; 0: the request does not fix it
    friend bool operator==(const AnswerShape&, const AnswerShape&) = default;
};

/// The shape of the normal answer to a request.
constexpr AnswerShape answer_shape(const wire::RequestShape& request) {
    return {request.function, request.fixed_length ? request.response_length : std::size_t{0}};
}

}  // namespace takt::bus
