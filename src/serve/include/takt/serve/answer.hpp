// From a request to its answer: the seam between the engines that move frames and whoever knows the answers.
#pragma once

#include <cstdint>
#include <string_view>

#include "takt/base/engine.hpp"
#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::serve {

/// Who asks, and how (docs/architecture.md). The texts are valid during the call.
struct Context {
    Instant time;            ///< when the request was complete
    UnitId unit;             ///< as it stands in the request
    bool broadcast = false;  ///< to every unit of a serial line: to be done, never answered
    std::string_view peer;   ///< "192.0.2.7:50100", or the serial port
    std::string_view role;   ///< from the peer's certificate; empty: none
};

/// Names an answer that is still awaited; unique among those of one responder.
using Token = std::uint32_t;

/// Gives the tokens of one responder, to whichever of its layers leaves an answer pending. One owner, one
/// thread.
class Tokens {
public:
    [[nodiscard]] Token next() { return ++last_; }

private:
    Token last_ = 0;
};

/// What becomes of a request.
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

/// What an engine hears on its line, whoever it is for: what diagnostic counters count.
enum class LineEvent : std::uint8_t {
    message,  ///< a good frame for, or from, any unit
    error,    ///< a frame with a bad checksum, or one that was no frame
    overrun,  ///< characters were lost by the receiver
};

/// Knows the answers. Must not block. Called on the engine's thread, from inside the engine.
class Responder {
public:
    /// Whether requests to that very unit are to be answered here. Engines of a serial line ignore all
    /// others.
    [[nodiscard]] virtual bool serves(UnitId unit) const = 0;

    /// @param pdu  the request, 1..253 bytes; nothing is assumed of them
    [[nodiscard]] virtual Answer handle(const Context& context, Bytes pdu) = 0;

    /// Told before the request of that frame is handled.
    virtual void heard(LineEvent /*event*/) {}

    /// Who waited for that pending answer is gone: it need not be given any more. Passed on by whoever stands
    /// before another responder; tokens that are not known are nothing.
    virtual void forget(Token /*token*/) {}

protected:
    ~Responder() = default;
};

/// Takes the answers to pending requests to the engines that wait for them: of one place, or of all places of
/// a responder.
class AnswerSink {
public:
    /// To be called on the engines' thread, but never from inside Responder::handle().
    /// @param token  of Answer::pending()
    /// @param pdu    1..253 bytes, copied
    /// @returns false: nobody waits for it any more
    virtual bool complete(Token token, Bytes pdu) = 0;

protected:
    ~AnswerSink() = default;
};

}  // namespace takt::serve
