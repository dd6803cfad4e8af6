// Observes the frames of a line: traffic logs, captures, tests. One interface for masters and slaves.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "takt/base/engine.hpp"
#include "takt/base/numbers.hpp"
#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/framer.hpp"

namespace takt::wire {

enum class Direction : std::uint8_t { sent, received };

/// What happens on a line besides frames.
enum class Incident : std::uint8_t {
    no_response,       ///< a request timed out
    late_response,     ///< the frame before is the response to a request that has ended
    surplus_response,  ///< the frame before is the response to no request
    connected,         ///< the port was opened, or the connection made
    disconnected,      ///< it was closed, or lost
};
std::string_view name(Incident incident);

/// Notified of every frame that an engine sends, and of every good frame that it receives (on a serial line
/// also those of other units). Called on the engine's thread from inside its members: must not block and must
/// not call the engine.
class TrafficObserver {
public:
    /// @param t     sent: when its first character starts; received: when its last character was complete
    /// @param raw   the frame as on the wire, valid during the call
    /// @param pdu   its PDU, valid during the call
    virtual void on_frame(Instant t, Direction direction, UnitId unit, Bytes pdu, Bytes raw) = 0;

    /// Bytes were received and dropped.
    /// @param raw  the bytes as far as they were kept; may be empty. Valid during the call
    virtual void on_fault(Instant t, FrameFault fault, Bytes raw) = 0;

    /// Masters only.
    /// @param unit     of a response; 0: of the line
    /// @param after    no_response: the wait of the request; late_response: how late it is; else zero
    /// @param instead  no_response, surplus_response: what came instead of the response that a request waits
    ///                 for; nothing: nothing did, or no request waits
    virtual void on_incident(Instant /*t*/, UnitId /*unit*/, Incident /*incident*/, Duration /*after*/,
                             const std::optional<Mismatch>& /*instead*/) {}

    /// The calls that follow are about the connection with that peer, "192.0.2.7:50100". The connections of a
    /// listener share one observer; masters and serial slaves do not call this.
    virtual void on_peer(std::string_view peer) { (void)peer; }

protected:
    ~TrafficObserver() = default;
};

}  // namespace takt::wire
