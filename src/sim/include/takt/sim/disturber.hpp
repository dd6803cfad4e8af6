// The seam at which faults enter a wire.
#pragma once

#include <cstdint>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/base/time.hpp"

namespace takt::sim {

/// A part of what arrives in the place of what was sent.
struct Piece {
    /// Serial lines: of no account, the pieces are one transmission. Streams: it arrives so much later than
    /// it would have.
    Duration delay{};
    /// Streams: it was only sent after the delay, and what is sent meanwhile arrives before it. Else what is
    /// sent later waits for it.
    bool sent_later = false;
    std::vector<std::uint8_t> bytes;
};

/// Called by a wire from inside run_until(). Must not call the wire, except from on_event().
class Disturber {
public:
    /// A participant sends.
    /// @param sender  as in Transmission
    /// @param arrives empty at first
    /// @returns false: it arrives as it is; true: `arrives` is what arrives instead, nothing: it is lost
    [[nodiscard]] virtual bool on_sent(Instant t, std::size_t sender, Bytes sent,
                                       std::vector<Piece>& arrives) = 0;

    /// A transmission has ended.
    /// @param sent   as the engine gave it
    /// @param heard  as it arrived
    virtual void on_arrived(Instant t, std::size_t sender, Bytes sent, Bytes heard) = 0;

    /// Whether somebody could take characters that were damaged on a line by a collision for a frame.
    /// @param heard  of one transmission, so far
    /// @param old    what ended among the first characters of it was looked at before
    /// @param sent   a frame that may be found
    [[nodiscard]] virtual bool misleads(Bytes heard, std::size_t old, Bytes sent) = 0;

    /// A connection was closed by one of its ends.
    virtual void on_closed(Instant t) = 0;

    /// When on_event() is to be called.
    [[nodiscard]] virtual Instant next_event() const = 0;
    virtual void on_event(Instant t) = 0;

protected:
    ~Disturber() = default;
};

}  // namespace takt::sim
