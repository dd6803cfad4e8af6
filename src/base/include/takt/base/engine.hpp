// The contract between engines and the drivers that move their bytes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "takt/base/result.hpp"
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
///   - on_close(t): the peer ended the connection, or the driver did because the engine asked for it. It can
///     be made again.
///   - opens_at(): when the engine needs a link after on_close(), or before the first on_link(). While the
///     driver waits for that instant, it also makes the calls above: the engine's time goes on.
///
/// One owner, one thread. Nothing blocks. Callbacks go only through injected sinks.
class Engine {
public:
    virtual void on_link(Instant t, bool up) = 0;
    virtual void on_bytes(Instant t, Bytes bytes) = 0;
    virtual void on_tick(Instant t) = 0;
    [[nodiscard]] virtual Bytes transmit(Instant t) = 0;
    [[nodiscard]] virtual Instant next_wakeup() const = 0;
    /// Where it makes no difference, the link was lost.
    virtual void on_close(Instant t) { on_link(t, false); }
    /// kNever: not before a change from outside. Nothing: the driver tries by its own back-off.
    [[nodiscard]] virtual std::optional<Instant> opens_at() const { return std::nullopt; }
    /// The received bytes for which the engine asked for the end of the connection: not_modbus, without
    /// subject. Also after on_link(down) and on_close(), until the next on_link(up).
    [[nodiscard]] virtual std::optional<Error> rejection() const { return std::nullopt; }

protected:
    ~Engine() = default;
};

}  // namespace takt
