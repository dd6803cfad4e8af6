// Media that connect engines in virtual time.
#pragma once

#include <cstddef>

#include "takt/base/engine.hpp"
#include "takt/base/time.hpp"

namespace takt::sim {

class Disturber;

/// A continuous transmission of one participant, as the other end receives it.
struct Transmission {
    std::size_t sender = 0;  ///< in the order in which the participants were attached
    Instant start;           ///< its first character begins
    Instant end;             ///< its last character is complete
    Bytes bytes;             ///< as sent; valid during the call
    bool collided = false;   ///< another participant sent at the same time, so the characters are damaged
    /// The received characters: different from `bytes` after a collision or a fault, empty if lost.
    /// Transmissions made by faults have no `bytes`.
    Bytes received;
};

/// Observes the measured view. Must not call the wire or its engines.
class WireObserver {
public:
    /// Called when the last character is complete.
    virtual void on_transmission(const Transmission& transmission) = 0;

protected:
    ~WireObserver() = default;
};

/// Engines joined by a medium, advanced by hand. Without clock and randomness: the same calls give the same
/// bytes at the same nanosecond. One owner, one thread.
class Wire {
public:
    virtual ~Wire() = default;

    /// Sets the link of all engines; bytes on their way are lost. Initially down.
    virtual void set_link(Instant t, bool up) = 0;

    /// Processes all events up to and including `t`. Also to be called after a change from outside, with the
    /// present time: engines are asked for bytes at its end.
    virtual void run_until(Instant t) = 0;

    /// The instant of the next event; kNever if only a change from outside can cause one.
    [[nodiscard]] virtual Instant next_wakeup() const = 0;

    /// The source of faults; at most one, outlives the wire; nullptr: none.
    virtual void set_disturber(Disturber* disturber) = 0;

    /// At most one; nullptr: none.
    virtual void set_observer(WireObserver* observer) = 0;
};

}  // namespace takt::sim
