// The interface between engines, which move frames, and responders, which answer requests.
#pragma once

#include <cstdint>
#include <string_view>

#include "takt/base/engine.hpp"
#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/pdu.hpp"
#include "takt/wire/request_view.hpp"

namespace takt::serve {

/// The origin of a request. The texts are valid during the call.
struct Context {
    Instant time;            ///< when the request was complete
    UnitId unit;             ///< as in the request
    bool broadcast = false;  ///< to every unit of a serial line: executed, never answered
    std::string_view peer;   ///< "192.0.2.7:50100", or the serial port
    std::string_view role;   ///< from the peer's certificate; empty: none
};

/// Identifies a pending answer; unique within one responder.
using Token = std::uint32_t;

/// Allocates the tokens of one responder, shared by all its layers. One owner, one thread.
class Tokens {
public:
    [[nodiscard]] Token next() { return ++last_; }

private:
    Token last_ = 0;
};

/// The answer to a request.
struct Answer {
    enum class Kind : std::uint8_t {
        silence,   ///< nothing is sent
        response,  ///< `pdu` is sent
        pending,   ///< the answer comes later through the engine's complete(), or never
    };

    Kind kind = Kind::silence;
    Token token = 0;   ///< of a pending answer
    Duration delay{};  ///< a response is not sent earlier than this after the request's end
    wire::Pdu pdu;     ///< of a response

    static Answer response(const wire::Pdu& pdu, Duration delay = {}) {
        return {Kind::response, 0, delay, pdu};
    }
    static Answer pending(Token token) { return {Kind::pending, token, {}, {}}; }
};

/// The exception response to a request whose first byte is `function`: function | 0x80, code.
wire::Pdu exception_to(std::uint8_t function, wire::ExceptionCode code);

/// Events on an engine's line, for any unit; the input of diagnostic counters.
enum class LineEvent : std::uint8_t {
    message,  ///< a good frame for, or from, any unit
    error,    ///< a frame with a bad checksum, or bytes that form no frame
    overrun,  ///< characters were lost by the receiver
};

/// Answers requests. Must not block. Called on the engine's thread, from inside the engine.
class Responder {
public:
    /// Whether this responder answers requests to exactly that unit. The engine of a serial line ignores all
    /// others.
    [[nodiscard]] virtual bool serves(UnitId unit) const = 0;

    /// @param request  decoded by the engine that received it; well formed or not. Valid during the call
    [[nodiscard]] virtual Answer handle(const Context& context, const wire::RequestView& request) = 0;

    /// Called before the request of that frame is handled.
    virtual void on_line_event(LineEvent /*event*/) {}

    /// The pending answer is no longer awaited. A responder that wraps another one passes the call on.
    /// Unknown tokens are ignored.
    virtual void forget(Token /*token*/) {}

protected:
    ~Responder() = default;
};

/// Delivers pending answers to the engines that wait for them, of one endpoint or of all endpoints of a
/// responder.
class AnswerSink {
public:
    /// To be called on the engines' thread, but never from inside Responder::handle().
    /// @param token  of Answer::pending()
    /// @param pdu    1..253 bytes, copied
    /// @returns false: the answer is no longer awaited
    virtual bool complete(Token token, Bytes pdu) = 0;

protected:
    ~AnswerSink() = default;
};

}  // namespace takt::serve
