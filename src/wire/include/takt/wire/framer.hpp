// Framers: bytes in any chunks, with their time, become frames. They resynchronise after garbage and never
// hold more than one frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "takt/base/bounded_vector.hpp"
#include "takt/base/engine.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/frame.hpp"

namespace takt::wire {

/// Why bytes were dropped.
enum class FrameFault : std::uint8_t {
    none,
    checksum,       ///< CRC or LRC does not fit
    too_short,      ///< ended by a silence or CR LF before it could be a frame
    too_long,       ///< more than the framing allows, without an end; tcp: more than there is room for
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
    /// RTU: silence that ends a frame. On a serial line t3.5; over a byte stream (RTU over TCP) or an adapter
    /// that delivers late, the longest pause inside a frame that is still believed. Above zero.
    Duration silence{};
    /// RTU, ASCII: time of one character on the line. Inside a frame the bytes of one push() are taken to
    /// have come one right behind the other, the last at `t`, as from a UART's buffer; between frames (except
    /// with `strict_pause`) also a lump that came as a whole at `t` may follow a silence, as from a
    /// pseudo-terminal. Zero: all of them at `t`.
    Duration character{};
    /// RTU: pauses above this inside a frame spoil it; zero: not checked.
    Duration strict_pause{};
    /// ASCII: longest pause between characters.
    Duration ascii_pause = std::chrono::seconds(1);
};

/// What happened to the bytes given to push() or to the silence told to on_tick().
struct FramerStep {
    std::size_t consumed = 0;             ///< bytes taken; push() again with the rest
    bool complete = false;                ///< frame() holds a frame with a good checksum
    FrameFault fault = FrameFault::none;  ///< bytes were dropped for this reason (not together with complete)
};

/// One direction of one line or connection. The same bytes at the same times give the same frames, however
/// they are cut into chunks.
///
/// - RTU: a frame is complete as soon as its length (foretold from function and byte count, for Side::slave
///   as a request or as a response) is reached and the CRC fits; where the function tells no length, or the
///   CRC does not fit there, after the silence. What follows a complete frame without a silence is dropped
///   (FrameFault::surplus, told once), except over a byte stream (`stream` below) and after expect_more(). A
///   frame that does not check is dropped as a whole at the next silence.
/// - ASCII: ':' always starts anew, CR LF ends; what stands outside is passed over.
/// - MBAP: by the length field; after bad_header nothing more is read.
///
/// Never allocates; one owner, one thread; time must not run backwards.
class Framer {
public:
    /// Bytes of room a framer of that framing works in.
    static constexpr std::size_t room(Framing framing) {
        switch (framing) {
            case Framing::rtu: return kMaxRtuFrame;
            case Framing::ascii: return kMaxAsciiFrame + kMaxDecoded;
            case Framing::tcp: break;
        }
        return kMaxTcpFrame;
    }
    static constexpr std::size_t kMostRoom = kMaxAsciiFrame + 2 + kMaxPdu;

    /// @param storage  room(config.framing) bytes; tcp: may be less, down to a frame of 9 bytes, where no
    /// longer
    ///                 frame is wanted: those are passed over (FrameFault::too_long). Must outlive the framer
    /// @param stream  RTU over a byte stream: frames may follow each other without a silence
    Framer(const FramerConfig& config, std::span<std::uint8_t> storage, bool stream = false);

    /// Takes bytes until a frame is complete or a fault is to be told, at most all of them.
    /// `t`: when the last of `bytes` arrived. A silence before `bytes` that ended a frame is noticed first,
    /// with consumed = 0: on_tick() need not have been called in time.
    [[nodiscard]] FramerStep push(Instant t, Bytes bytes);

    /// Notices silences that have passed by `t`.
    [[nodiscard]] FramerStep on_tick(Instant t);

    /// When on_tick() can have something to tell; kNever while idle.
    [[nodiscard]] Instant next_wakeup() const;

    /// The frame of the last step with complete = true, or (tcp, after too_long) the beginning of the one
    /// that was passed over: its PDU holds the function at least. Valid until the next push(), on_tick() or
    /// reset().
    [[nodiscard]] Frame frame() const;

    /// The bytes of that frame as they stood on the wire, for traffic logs.
    [[nodiscard]] Bytes raw() const;

    /// For a slave that shares its line, after a complete frame for a unit that is not its own: what follows
    /// without a silence is then the next frame instead of surplus. An adapter that delivers late may hand
    /// over another slave's response and the next request in one piece, and the silence between them is not
    /// seen. Not after a frame for an own unit: nobody may speak before that is answered. Once the frame just
    /// told was another unit's request, frames with its unit and function are measured as responses only, so
    /// that data inside one is not taken for a frame.
    void expect_more();

    /// Forgets everything, also a bad header. For a new connection, and when a master starts a transaction.
    void reset();

private:
    static constexpr std::size_t kMaxDecoded = 2 + kMaxPdu;  // unit, PDU, LRC

    enum class State : std::uint8_t {
        idle,       // between frames
        receiving,  // raw_ holds the beginning of a frame
        ending,     // ASCII: its CR was there
        complete,   // raw_ holds a frame that was told
        skipping,   // RTU: up to the next silence
        dead,       // MBAP: after a bad header
    };
    // A request of another unit, as far as its response repeats it.
    struct Exchange {
        std::uint8_t unit = 0;
        std::uint8_t function = 0;
        friend bool operator==(const Exchange&, const Exchange&) = default;
    };

    FramerStep push_rtu(Instant t, Bytes bytes);
    FramerStep push_ascii(Instant t, Bytes bytes);
    FramerStep push_tcp(Bytes bytes);

    [[nodiscard]] bool rtu_length_reached() const;
    [[nodiscard]] Exchange rtu_exchange() const;
    FramerStep end_rtu();
    FrameFault take_digit(std::uint8_t character);
    FramerStep end_ascii(std::size_t consumed);
    [[nodiscard]] bool mbap_header_good() const;
    FramerStep skip(std::size_t there);

    [[nodiscard]] bool inside() const { return state_ == State::receiving || state_ == State::ending; }
    void begin();
    FramerStep drop(FrameFault fault, std::size_t consumed, State next);
    FramerStep tell(std::size_t consumed);

    FramerConfig config_;
    bool stream_;
    State state_ = State::idle;
    bool more_ = false;                // expect_more() was called for the frame that was told
    std::optional<Exchange> awaited_;  // RTU slave: another unit's request whose response is to come
    Instant last_;                     // when the last byte was complete
    std::uint16_t crc_ = 0;            // RTU: of raw_
    std::size_t to_skip_ = 0;          // MBAP: bytes of a frame there is no room for
    BoundedVector<std::uint8_t> raw_;
    BoundedVector<std::uint8_t> decoded_;  // ASCII: unit, PDU, LRC
};

/// Room for a framer of any framing.
struct FramerRoom {
    std::array<std::uint8_t, Framer::kMostRoom> framer_room{};
};

/// A framer with its own room.
class StandaloneFramer final : FramerRoom, public Framer {
public:
    explicit StandaloneFramer(const FramerConfig& config, bool stream = false)
        : Framer(config, framer_room, stream) {}
};

}  // namespace takt::wire
