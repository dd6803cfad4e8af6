// Bytes between engines in virtual time.
#pragma once

#include <cstddef>

#include "takt/base/engine.hpp"
#include "takt/base/time.hpp"

namespace takt::sim {

class Disturber;

/// What one participant put on the wire without a break, as the other end sees it.
struct Transmission {
    std::size_t sender = 0;  ///< in the order in which the participants were attached
    Instant start;           ///< its first character begins
    Instant end;             ///< its last character is complete
    Bytes bytes;             ///< as sent; valid during the call
    bool collided = false;   ///< another one sent at the same time: others heard something else
    /// As it arrived: other than `bytes` after a collision or a fault, nothing where it was lost. What faults
    /// send has no `bytes`.
    Bytes heard;
};

/// The measured view. Must not call the wire or its engines.
class WireObserver {
public:
    /// Told when the last character is complete.
    virtual void on_transmission(const Transmission& transmission) = 0;

protected:
    ~WireObserver() = default;
};

/// Engines joined by a medium, run by hand: no clock, no randomness; the same calls give the same bytes at
/// the same nanosecond. One owner, one thread.
class Wire {
public:
    virtual ~Wire() = default;

    /// Tells all engines that the link is up or down; what was on its way is lost. Begins down.
    virtual void set_link(Instant t, bool up) = 0;

    /// Lets happen what is due up to and including `t`. Also to be called after a change from outside, with
    /// the present time: engines are asked for bytes at its end.
    virtual void run_until(Instant t) = 0;

    /// When the next thing happens; kNever when only a change from outside can make one.
    [[nodiscard]] virtual Instant next_wakeup() const = 0;

    /// Who spoils what is sent; at most one, outlives the wire; nullptr: nobody.
    virtual void set_disturber(Disturber* disturber) = 0;

    /// At most one; nullptr: none.
    virtual void set_observer(WireObserver* observer) = 0;
};

}  // namespace takt::sim
