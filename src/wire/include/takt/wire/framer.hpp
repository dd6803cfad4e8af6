// Framers: bytes in any chunks, with their time, become frames. They resynchronise after garbage and never hold
// more than one frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "takt/base/engine.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/frame.hpp"

namespace takt::wire {

/// Why bytes were dropped.
enum class FrameFault : std::uint8_t {
    none,
    checksum,       ///< CRC or LRC does not fit
    too_short,      ///< ended by a silence or CR LF before it could be a frame
    too_long,       ///< more than the framing allows, without an end
    pause,          ///< a pause inside the frame longer than allowed (RTU strict: t1.5; ASCII: 1 s)
    bad_character,  ///< ASCII: no hexadecimal digit, an odd number of them, CR without LF
    bad_header,     ///< MBAP: protocol id not 0, length below 2 or above 254; the connection must be closed
    surplus,        ///< bytes behind a complete frame, before a silence
};
std::string_view name(FrameFault fault);

/// Whose frames are expected: it decides from which bytes an RTU frame's length is foretold.
enum class Side : std::uint8_t {
    master,  ///< responses
    slave,   ///< requests, and on a serial line other slaves' responses
};

struct FramerConfig {
    Framing framing = Framing::rtu;
    Side side = Side::slave;
    /// RTU: silence that ends a frame. On a serial line t3.5; over a byte stream (RTU over TCP) or an adapter that
    /// delivers late, the longest pause inside a frame that is still believed.
    Duration silence{};
    /// RTU: pauses above this inside a frame spoil it; zero: not checked.
    Duration strict_pause{};
    /// ASCII: longest pause between characters.
    Duration ascii_pause = std::chrono::seconds(1);
};

/// What happened to the bytes given to push() or to the silence told to on_tick().
struct FramerStep {
    std::size_t consumed = 0;              ///< bytes taken; push() again with the rest
    bool complete = false;                 ///< frame() holds a frame with a good checksum
    FrameFault fault = FrameFault::none;   ///< bytes were dropped for this reason (not together with complete)
};

/// One direction of one line or connection.
///
/// RTU: a frame is complete as soon as its length (foretold from function and byte count, for Side::slave as a
/// request or as a response) is reached and the CRC fits; where the function tells no length, after the silence.
/// What follows a complete frame without a silence is dropped (FrameFault::surplus), except over a byte stream
/// (`stream` below). A frame that does not check is dropped as a whole at the next silence.
/// ASCII: ':' always starts anew; CR LF ends. MBAP: by the length field; after bad_header nothing more is read.
///
/// Never allocates; one owner, one thread; time must not run backwards.
class Framer {
public:
    /// @param stream  RTU over a byte stream: frames may follow each other without a silence
    explicit Framer(const FramerConfig& config, bool stream = false);

    /// Takes bytes until a frame is complete or a fault is to be told, at most all of them.
    /// `t`: when the last of `bytes` arrived. A silence before `bytes` that ended a frame is noticed first, with
    /// consumed = 0: on_tick() need not have been called in time.
    [[nodiscard]] FramerStep push(Instant t, Bytes bytes);

    /// Notices silences that have passed by `t`.
    [[nodiscard]] FramerStep on_tick(Instant t);

    /// When on_tick() can have something to tell; kNever while idle.
    [[nodiscard]] Instant next_wakeup() const;

    /// The frame of the last step with complete = true; valid until the next push(), on_tick() or reset().
    [[nodiscard]] Frame frame() const;

    /// The bytes of that frame as they stood on the wire, for traffic logs.
    [[nodiscard]] Bytes raw() const;

    /// Forgets everything, also a bad header. For a new connection, and when a master starts a transaction.
    void reset();

private:
    FramerStep push_rtu(Instant t, Bytes bytes);
    FramerStep push_ascii(Instant t, Bytes bytes);
    FramerStep push_tcp(Bytes bytes);
    // ... completed by the implementation
};

}  // namespace takt::wire
