// The slave engine of a serial line.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "takt/base/inplace_string.hpp"
#include "takt/base/inplace_vector.hpp"
#include "takt/serve/answer.hpp"
#include "takt/serve/counters.hpp"
#include "takt/serve/echo_filter.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/framer.hpp"
#include "takt/wire/line_timing.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::serve {

struct SerialConfig {
    wire::Framing framing = wire::Framing::rtu;  ///< rtu or ascii
    wire::CharacterFormat format;  ///< gives the silences and the length of what is sent; baud > 0
    /// Least time from the end of a request to its answer; on RTU at least t3.5.
    Duration turnaround{};
    /// RTU: the pause that ends a frame; longer for adapters that deliver late. Zero: t3.5.
    Duration frame_silence{};
    /// RTU: pauses above t1.5 inside a frame make it invalid. Otherwise a frame that an adapter delivers in
    /// chunks, with pauses up to `byte_timeout`, is reassembled if nothing else fits.
    bool strict = false;
    /// Longest pause between two bytes of a frame; RTU: at least t3.5, no effect with `strict`. Zero: RTU
    /// kDeliveryPause, ASCII 1 s.
    Duration byte_timeout{};
    /// Longest time from the first byte of a frame to its last. Zero: default_frame_timeout().
    Duration frame_timeout{};
    /// A new request to a unit whose previous answer is still waiting. false: it replaces the previous one,
    /// which the master has given up. true: it is dropped, as by a device that does not receive while it
    /// works.
    bool finish_first = false;
    /// A pseudo-terminal, where bytes take no time: a frame equal to the answer to a write is the master's
    /// next request, not the own echo.
    bool untimed = false;
    InplaceString<64> peer;  ///< Context::peer
};

/// RTU 2 s, ASCII 1 min, but at least twice the time of the longest frame. ASCII allows pauses of 1 s between
/// characters (MODBUS over Serial Line V1.02, section 2.5.2.1), as from a person at a terminal.
[[nodiscard]] Duration default_frame_timeout(wire::Framing framing, const wire::CharacterFormat& format);

/// Answers the requests to the responder's units on a serial line (MODBUS over Serial Line V1.02, section 2).
///
/// Frames of other units, frames with a bad checksum, incomplete and slow frames are dropped and counted. A
/// broken RTU frame is counted once, however it is cut by pauses: after it, pieces without the length of a
/// frame are part of it, until a good frame or a silence of `byte_timeout` + kResyncSilence. Broadcasts are
/// executed, never answered. An answer is sent after its turnaround and t3.5 of silence (ASCII: at once),
/// never during other bytes. An answer that is delayed by more than kLatest is dropped, because it could be
/// taken for that of a later request. Answers of several units may wait (slow or pending ones), at most
/// kMaxWaiting. The own echo is detected and dropped.
///
/// Never allocates. One owner, one thread; see Engine for the calls.
class SerialSlave final : public Engine {
public:
    static constexpr std::size_t kMaxWaiting = 8;
    static constexpr Duration kLatest = std::chrono::milliseconds(500);
    static constexpr Duration kDeliveryPause = std::chrono::milliseconds(30);
    /// RTU: after a broken frame, a silence that is longer than `byte_timeout` by this time separates frames.
    static constexpr Duration kResyncSilence = std::chrono::milliseconds(300);

    /// @param responder, observer  outlive the engine; the observer may be absent
    SerialSlave(const SerialConfig& config, Responder& responder, wire::TrafficObserver* observer = nullptr);

    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;

    /// Completes a pending request. Afterwards transmit() is to be called.
    /// @param pdu  1..253 bytes
    /// @returns false if the answer is no longer awaited (another request replaced it, the link was lost)
    bool complete(Instant t, Token token, Bytes pdu);

    [[nodiscard]] const Counters& counters() const { return counters_; }

private:
    struct Waiting {
        UnitId unit;
        bool pending = false;
        Token token = 0;
        Instant asked;  // when its request was complete
        Instant due;    // earliest time to send it
        wire::Pdu pdu;
    };

    void receive(Instant t, Bytes bytes);
    void receive_tolerant(Instant t, Bytes bytes);
    void settle(Instant t, const wire::FramerStep& step);
    void settle_tolerant(Instant t, const wire::FramerStep& step);
    void note_silence(Instant t, std::size_t received);
    void note(Instant t, const wire::FramerStep& step);
    void report(Instant t, const wire::FramerStep& step, Bytes dropped);
    void report_broken(Instant t);
    void take(Instant t, wire::Framer& framer);
    void enqueue(Instant t, UnitId unit, const Answer& answer);
    [[nodiscard]] Waiting* waiting_of(UnitId unit);
    void drop(Waiting& waiting);
    void drop_stale();
    Bytes send(Instant t, const Waiting& waiting);

    Responder& responder_;
    wire::TrafficObserver* observer_;
    SerialConfig config_;
    Duration silence_;  // before an own frame: t3.5, zero in ASCII
    wire::StandaloneFramer framer_;
    wire::StandaloneFramer tolerant_framer_;  // the same bytes with longer silences; RTU, not strict
    // A chunk that framer_ dropped and that may be part of a frame of tolerant_framer_. Not reported yet.
    wire::FramerStep broken_;
    bool out_of_step_ = false;               // a broken frame was counted: pieces that follow are part of it
    Instant last_byte_at_ = Instant::min();  // when the last bytes were received
    EchoFilter echo_;
    Counters counters_;
    bool up_ = false;
    Instant quiet_at_;  // end of the silence before an own frame
    InplaceVector<Waiting, kMaxWaiting> waiting_;
    wire::FrameBytes out_;
};

}  // namespace takt::serve
