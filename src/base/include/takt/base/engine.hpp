// The contract between the pure core and the shell that moves its bytes.
#pragma once

#include <cstdint>
#include <span>

#include "takt/base/time.hpp"

namespace takt {

using Bytes = std::span<const std::uint8_t>;

/// One end of one line or connection: bytes and time in, bytes and the next wake-up out
/// (docs/architecture.md).
///
/// The driver (a real port, a socket, the simulation) calls, always with a time that does not run backwards:
///   on_bytes(t, bytes)  bytes as they arrived; t is the moment the last of them was complete
///   on_tick(t)          at next_wakeup() or later; harmless at any other time
///   transmit(t)         after each of the above and after every change from outside, until it answers
///   nothing:
///                       the bytes to send now. They stay valid until the next call of any member. The engine
///                       takes them as on the wire from t on and computes their end from the bit rate.
///   next_wakeup()       kNever when only bytes or a change from outside can make something happen
///   on_link(t, up)      the port was opened or the connection made / it is gone; engines start with the link
///   down
///
/// One owner, one thread; nothing blocks, and nothing is called back from inside except through injected
/// sinks.
class Engine {
public:
    virtual void on_link(Instant t, bool up) = 0;
    virtual void on_bytes(Instant t, Bytes bytes) = 0;
    virtual void on_tick(Instant t) = 0;
    [[nodiscard]] virtual Bytes transmit(Instant t) = 0;
    [[nodiscard]] virtual Instant next_wakeup() const = 0;

protected:
    ~Engine() = default;
};

}  // namespace takt
