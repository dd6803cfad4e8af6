// The slave end of a serial line.
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
    /// Least time from the end of a request to its answer; on RTU at least t3.5 counts.
    Duration turnaround{};
    /// RTU: the pause that ends a frame, longer for adapters that deliver late; zero: t3.5.
    Duration frame_silence{};
    /// RTU: pauses above t1.5 inside a frame spoil it. Else a frame that adapters deliver in lumps, with
    /// pauses up to kLumps between them, is put together again when nothing else fits.
    bool strict = false;
    /// A request that comes while the answer to an earlier one to the same unit waits: false: it takes its
    /// place (the master has given up the earlier one); true: it is dropped, as by a device that is deaf
    /// while it works.
    bool finish_first = false;
    /// A pseudo-terminal, where bytes take no time: what repeats the answer to a write is the master's next
    /// request, not the own echo, however soon it comes.
    bool untimed = false;
    InplaceString<64> peer;  ///< Context::peer
};

/// Answers the requests to the responder's units on a serial line (MODBUS over Serial Line V1.02, section 2).
///
/// Frames of other units, with a bad checksum or in pieces are dropped in silence and counted. Broadcasts are
/// done, never answered. An answer goes out when its turnaround has passed and the line has been silent for
/// t3.5 (ASCII: at once), never into others' bytes; what these delay by more than kLatest is
/// dropped, for a stale answer could be taken for another request's. Answers of several units may wait at a
/// time (slow or pending ones), at most kMaxWaiting. Own echo is found out and dropped.
///
/// Never allocates. One owner, one thread; see Engine for the calls.
class SerialSlave final : public Engine {
public:
    static constexpr std::size_t kMaxWaiting = 8;
    static constexpr Duration kLatest = std::chrono::milliseconds(500);
    static constexpr Duration kLumps = std::chrono::milliseconds(30);

    /// @param responder, observer  outlive the engine; the observer may be absent
    SerialSlave(const SerialConfig& config, Responder& responder, wire::TrafficObserver* observer = nullptr);

    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;

    /// Gives the answer to a pending request; afterwards transmit() is to be called.
    /// @param pdu  1..253 bytes
    /// @returns false when nobody waits for it any more (another request took its place, the link went down)
    bool complete(Instant t, Token token, Bytes pdu);

    [[nodiscard]] const Counters& counters() const { return counters_; }

private:
    struct Waiting {
        UnitId unit;
        bool pending = false;
        Token token = 0;
        Instant asked;  // when its request was complete
        Instant due;    // the earliest it may go out
        wire::Pdu pdu;
    };

    void hear(Instant t, Bytes bytes);
    void hear_lump(Instant t, Bytes bytes);
    void settle(Instant t, const wire::FramerStep& step);
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
    wire::StandaloneFramer lumps_;  // the same bytes with longer silences; RTU, not strict
    EchoFilter echo_;
    Counters counters_;
    bool up_ = false;
    Instant quiet_at_;  // the line will have been silent long enough for an own frame
    InplaceVector<Waiting, kMaxWaiting> waiting_;
    wire::FrameBytes out_;
};

}  // namespace takt::serve
