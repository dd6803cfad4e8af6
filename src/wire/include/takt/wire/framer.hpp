// Framers cut a stream of bytes into frames. Bytes come in chunks of any size, with their time. A framer
// resynchronises after garbage and holds at most one frame.
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
    checksum,       ///< CRC or LRC is wrong
    too_short,      ///< ended by a silence or CR LF before it could be a frame
    too_long,       ///< more than the framing allows, without an end; tcp: more than the storage holds
    pause,          ///< a pause inside the frame was too long (RTU strict: t1.5; ASCII: 1 s)
    bad_character,  ///< ASCII: not a hexadecimal digit, an odd number of digits, CR without LF
    bad_header,     ///< MBAP: protocol id not 0, length below 2 or above 254; the connection must be closed
    surplus,        ///< bytes after a complete frame without a silence between them
    too_slow,       ///< the frame was not complete after FramerConfig::frame_time
};
std::string_view name(FrameFault fault);

/// The sender of the received frames. It decides how the length of an RTU frame follows from its first bytes.
enum class Side : std::uint8_t {
    master,  ///< responses
    slave,   ///< requests, and on a serial line the responses of other slaves
};

struct FramerConfig {
    Framing framing = Framing::rtu;
    Side side = Side::slave;
    /// RTU: the silence that ends a frame; above zero. On a serial line t3.5. Over a byte stream (RTU over
    /// TCP), or with an adapter that delivers late, the longest pause that may occur inside a frame.
    Duration silence{};
    /// RTU, ASCII: the time of one character on the line. Inside a frame the bytes of one push() count as
    /// received back to back, the last at `t`, as from a UART's buffer. Between frames, except with
    /// `strict_pause`, they may also have arrived all at once at `t`, as from a pseudo-terminal. Zero: all
    /// bytes arrive at `t`.
    Duration character{};
    /// RTU: a longer pause inside a frame invalidates it; zero: not checked.
    Duration strict_pause{};
    /// ASCII: longest pause between characters.
    Duration ascii_pause = std::chrono::seconds(1);
    /// RTU, ASCII: longest time from the first byte of a frame to its last; zero: not limited.
    Duration frame_time{};
    /// MBAP, master: the length in the header of the expected response may be off by one. The response then
    /// ends where its own counts say; one further byte is awaited for `silence` where the header promises it.
    bool length_tolerance = false;
};

/// The response that a master waits for.
struct ExpectedResponse {
    UnitId unit;
    std::uint8_t function = 0;
    /// Characters of the frame of the normal response. 0: the request does not fix them.
    std::size_t length = 0;
    std::uint16_t transaction = 0;  ///< MBAP
};

/// The result of push() or on_tick().
struct FramerStep {
    std::size_t consumed = 0;             ///< bytes taken; push() again with the rest
    bool complete = false;                ///< frame() holds a frame with a good checksum
    FrameFault fault = FrameFault::none;  ///< bytes were dropped for this reason (not together with complete)
    /// The dropped bytes have the length of a frame. After expect_response(): of the expected one, or they
    /// end with a frame that begins like it.
    bool whole = false;
    /// `whole`, and they begin like the expected frame: it came damaged. Else it may still come.
    bool came = false;
};

/// Receives one direction of one line or connection. The result does not depend on how the bytes are cut into
/// chunks, only on the bytes and their times.
///
/// - RTU: the length of a frame is derived from the function and the byte count; on Side::slave a frame may
///   be a request or a response. A frame is complete when it has this length and a good CRC. If the function
///   does not define a length, or the CRC is wrong there, the frame ends at the silence. Bytes after a
///   complete frame without a silence are dropped (FrameFault::surplus, reported once), except over a byte
///   stream (`stream` below) and after expect_more(). A frame with a wrong CRC is dropped at the next
///   silence. Over a byte stream, a slave finds the next request behind bytes that are none, at once if their
///   length as a request has passed, else after the silence. A master finds the response that it expects
///   inside other bytes, see expect_response().
/// - ASCII: ':' starts a frame, also inside another one; CR LF ends it. Bytes between frames are ignored.
/// - MBAP: the header has a length field. After bad_header nothing more is read. Without length_tolerance the
///   expected response is of no account.
///
/// Never allocates; one owner, one thread; time must not run backwards.
class Framer {
public:
    /// Bytes of storage that a framer of that framing needs.
    static constexpr std::size_t storage_size(Framing framing) {
        switch (framing) {
            case Framing::rtu: return kMaxRtuFrame;
            case Framing::ascii: return kMaxAsciiFrame + kMaxDecoded;
            case Framing::tcp: break;
        }
        return kMaxTcpFrame;
    }
    static constexpr std::size_t kMaxStorage = kMaxAsciiFrame + 2 + kMaxPdu;

    /// @param storage  storage_size(config.framing) bytes; must outlive the framer. tcp: it may be shorter,
    ///                 at least 9 bytes; longer frames are then skipped (FrameFault::too_long)
    /// @param stream  RTU over a byte stream: frames may follow each other without a silence
    Framer(const FramerConfig& config, std::span<std::uint8_t> storage, bool stream = false);

    /// Consumes bytes until a frame is complete or a fault occurs. If a silence before `bytes` ended a frame,
    /// that frame is returned first, with consumed = 0: on_tick() need not have been called in time.
    /// @param t  when the last of `bytes` arrived
    [[nodiscard]] FramerStep push(Instant t, Bytes bytes);

    /// Ends a frame whose silence has passed at `t`.
    [[nodiscard]] FramerStep on_tick(Instant t);

    /// When on_tick() can have a result; kNever while idle.
    [[nodiscard]] Instant next_wakeup() const;

    /// The frame of the last step with complete = true. tcp, after too_long: the beginning of the skipped
    /// frame; its PDU has at least the function. Valid until the next push(), on_tick() or reset().
    [[nodiscard]] Frame frame() const;

    /// The bytes of frame() as on the wire, for traffic logs; valid as long as it.
    [[nodiscard]] Bytes raw() const;

    /// The bytes that the last step dropped, as far as they were kept: of surplus bytes those of the last
    /// push(). Valid until the next push(), on_tick() or reset(), and as long as the bytes given to push().
    [[nodiscard]] Bytes dropped() const { return dropped_; }

    /// Accepts a further frame without a silence before it. A slave on a shared line calls this after a frame
    /// for another unit: an adapter that delivers late may hand over the response of another slave together
    /// with the next request. Not after a frame for an own unit, which must be answered first.
    /// If the frame was a request of another unit, the next frame with its unit and function can only be its
    /// response. So data inside the response cannot pass for a request.
    void expect_more();

    /// Side::master, after reset(): a request was sent. RTU has no mark for the beginning of a frame: noise
    /// before a response would be taken for it. So this response is also found behind other bytes: if it has
    /// the unit, the function (or its exception), the length and a good CRC. No other frame is searched. The
    /// search begins when the bytes cannot be a frame from their first one on: no device has that unit, the
    /// function defines no such length, or its length was reached and the CRC is wrong; and when a silence
    /// ends them. So data inside the frame of another unit cannot pass for the response.
    ///
    /// If the response came with a wrong checksum, its bytes are dropped without waiting for a silence,
    /// unless the expected response may have begun inside them.
    void expect_response(const ExpectedResponse& response) { expected_ = response; }

    /// RTU: the owner stops waiting. Finds the expected response inside a frame that has not ended yet.
    [[nodiscard]] FramerStep find_expected();

    /// What was received of a frame that is not complete. Valid until the next push(), on_tick() or reset().
    [[nodiscard]] Bytes incomplete() const { return inside() ? raw_.span() : Bytes(); }

    /// MBAP: what was received of a frame, or the complete frame, begins with a whole response by its own
    /// counts, and its header promises one byte more or less.
    [[nodiscard]] bool length_is_off() const;

    /// Starts over, also after a bad header. For a new connection, and when a master starts a transaction.
    void reset();

private:
    static constexpr std::size_t kMaxDecoded = 2 + kMaxPdu;  // unit, PDU, LRC

    enum class State : std::uint8_t {
        idle,             // between frames
        receiving,        // raw_ holds the beginning of a frame
        ending,           // ASCII: its CR was there; MBAP: its last byte may be missing
        complete,         // raw_ holds a frame that was returned
        skipping,         // RTU: up to the next silence
        resynchronising,  // RTU: raw_ begins with something else than a request (or the expected response)
        dead,             // MBAP: after a bad header
    };
    // The part of a request that its response repeats.
    struct Exchange {
        std::uint8_t unit = 0;
        std::uint8_t function = 0;
        friend bool operator==(const Exchange&, const Exchange&) = default;
    };

    FramerStep push_rtu(Instant t, Bytes bytes);
    FramerStep push_ascii(Instant t, Bytes bytes);
    FramerStep push_tcp(Bytes bytes);

    [[nodiscard]] bool rtu_length_reached() const;
    [[nodiscard]] bool rtu_length_passed() const;
    [[nodiscard]] bool rtu_beginning_doubtful() const;
    [[nodiscard]] bool may_resynchronise() const;
    [[nodiscard]] bool find_request();
    [[nodiscard]] bool is_expected(Bytes beginning) const;
    [[nodiscard]] std::size_t expected_length(Bytes beginning) const;
    [[nodiscard]] bool may_begin_expected(Bytes beginning) const;
    [[nodiscard]] bool rtu_beginning_impossible() const;
    [[nodiscard]] bool expected_came_damaged() const;
    [[nodiscard]] bool find_response();
    [[nodiscard]] Exchange rtu_exchange() const;
    FramerStep end_rtu();
    FrameFault take_digit(std::uint8_t character);
    [[nodiscard]] bool too_slow(Instant t) const;
    FramerStep end_ascii(std::size_t consumed);
    [[nodiscard]] bool mbap_header_good() const;
    [[nodiscard]] std::size_t mbap_length(std::size_t promised) const;
    FramerStep skip(std::size_t there);

    [[nodiscard]] bool inside() const {
        return state_ == State::receiving || state_ == State::ending || state_ == State::resynchronising;
    }
    void begin();
    FramerStep drop(FrameFault fault, std::size_t consumed, State next);
    FramerStep complete_frame(std::size_t consumed);

    FramerConfig config_;
    bool stream_;
    State state_ = State::idle;
    bool more_ = false;                // expect_more() was called for the frame returned last
    std::optional<Exchange> awaited_;  // RTU slave: a request of another unit that has no response yet
    std::optional<ExpectedResponse> expected_;  // master
    bool shifted_ = false;                      // RTU master: first bytes of raw_ were dropped
    bool damaged_ = false;                      // ASCII master: raw_ has a bad character
    Instant last_;                              // when the last byte was complete
    Instant begun_;                             // RTU, ASCII: when the first bytes of raw_ came
    std::uint16_t crc_ = 0;                     // RTU: of raw_
    std::size_t to_skip_ = 0;                   // MBAP: remaining bytes of a frame that is too long
    BoundedVector<std::uint8_t> raw_;
    Bytes dropped_;                        // in the storage of raw_, or those given to push()
    BoundedVector<std::uint8_t> decoded_;  // ASCII: unit, PDU, LRC
};

/// Storage for a framer of any framing.
struct FramerStorage {
    std::array<std::uint8_t, Framer::kMaxStorage> framer_storage{};
};

/// A framer with its own storage.
class StandaloneFramer final : FramerStorage, public Framer {
public:
    explicit StandaloneFramer(const FramerConfig& config, bool stream = false)
        : Framer(config, framer_storage, stream) {}
};

}  // namespace takt::wire
