// The contract between engines and the drivers that move their bytes.
#pragma once

#include <cstdint>
#include <span>

#include "takt/base/time.hpp"

namespace takt {

using Bytes = std::span<const std::uint8_t>;

/// One end of a line or connection: takes bytes and time, gives bytes and the next wake-up
/// (docs/architecture.md).
///
/// The driver (a real port, a socket, the simulation) makes these calls. Time must not run backwards.
///   - on_bytes(t, bytes): received bytes; t is the end of the last one.
///   - on_tick(t): at next_wakeup() or later; no effect at any other time.
///   - transmit(t): after each call above and after every change from outside, until it returns nothing. The
///     result is to be sent now and stays valid until the next call of any member. The engine assumes that it
///     is on the wire from t on, and computes its end from the bit rate.
///   - next_wakeup(): kNever if only bytes or a change from outside can cause an action.
///   - on_link(t, up): the link was opened or lost. Engines start with the link down.
///
/// One owner, one thread. Nothing blocks. Callbacks go only through injected sinks.
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
