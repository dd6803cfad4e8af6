// The interface through which faults enter a wire.
#pragma once

#include <cstdint>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/base/time.hpp"
#include "takt/serve/server.hpp"

namespace takt::sim {

/// A piece of what arrives instead of a transmission.
struct Piece {
    /// Streams: additional delay of the piece. Serial lines: ignored, the pieces form one transmission.
    Duration delay{};
    /// Streams: true: the piece is sent only after the delay, so later bytes may overtake it; false: later
    /// bytes wait.
    bool sent_later = false;
    std::vector<std::uint8_t> bytes;
};

/// Called by a wire from inside run_until(). Must not call the wire, except from on_event().
class Disturber {
public:
    /// A participant transmits.
    /// @param sender  as in Transmission
    /// @param arrives empty at first
    /// @returns false: it arrives unchanged; true: `arrives` replaces it, empty: it is lost
    [[nodiscard]] virtual bool on_sent(Instant t, std::size_t sender, Bytes sent,
                                       std::vector<Piece>& arrives) = 0;

    /// A transmission has ended.
    /// @param sent   as the engine gave it
    /// @param received  as it arrived
    virtual void on_arrived(Instant t, std::size_t sender, Bytes sent, Bytes received) = 0;

    /// Whether a receiver could take characters damaged by a collision for a frame.
    /// @param received  the received characters of one transmission so far
    /// @param old    leading characters that were checked before
    /// @param sent   a sent frame, which may be found
    [[nodiscard]] virtual bool misleads(Bytes received, std::size_t old, Bytes sent) = 0;

    /// A connection was closed by one of its ends.
    virtual void on_closed(Instant t) = 0;

    /// When on_event() is to be called.
    [[nodiscard]] virtual Instant next_event() const = 0;
    virtual void on_event(Instant t) = 0;

protected:
    ~Disturber() = default;
};

class ByteStream;
class SerialBus;

/// The faults of one SimulatedLine, which drives it: of its wire, and as the responder of its answers.
class LineFaults : public serve::Responder, public Disturber {
public:
    virtual ~LineFaults() = default;
    /// Before anything happens on it; it outlives the faults. One of the two, for the kind of the line.
    virtual void work_on(SerialBus&) {}
    virtual void work_on(ByteStream&) {}
    /// The line was started or stopped from outside.
    virtual void run(Instant t, bool on) = 0;
};

}  // namespace takt::sim
