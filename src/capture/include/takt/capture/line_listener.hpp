// A third party on a line: bytes in, exchanges out. It sends nothing.
#pragma once

#include <array>
#include <optional>

#include "takt/capture/frame_finder.hpp"
#include "takt/capture/heard_exchange.hpp"
#include "takt/capture/line_statistics.hpp"
#include "takt/capture/serial_pairing.hpp"

namespace takt::capture {

struct ListenConfig {
    FrameFinderConfig frames;
    Duration timeout = std::chrono::seconds(1);  ///< a request waits so long for its response
};

/// Follows one line: finds frames, pairs requests with responses (capture::SerialPairing), reports exchanges
/// to the observer and keeps statistics. Allocates for statistics only, within the bounds of LineStatistics.
/// One owner, one thread; time must not run backwards.
class LineListener final : private LineSink {
public:
    LineListener(const ListenConfig& config, ListenObserver& observer);

    /// @param t  when the last of `bytes` arrived
    void on_bytes(Instant t, Bytes bytes) { finder_.push(t, bytes); }
    void on_tick(Instant t);
    /// When on_tick() can have a result.
    [[nodiscard]] Instant next_wakeup() const;
    /// One whole frame, with its checksum, from a capture: its characters have no times of their own.
    void on_captured(Instant t, Bytes frame, capture::Sender sender = capture::Sender::unknown);
    /// Bytes of a capture that are no frame.
    void on_captured_damage(Instant t, Bytes bytes) { on_damaged({.begin = t, .end = t, .bytes = bytes}); }
    /// The end: bytes that are no frame are damaged, requests that wait are open.
    void end();

    [[nodiscard]] const LineStatistics& statistics() const { return statistics_; }

private:
    void on_frame(const LineFrame& frame) override { on_frame(frame, capture::Sender::unknown); }
    void on_frame(const LineFrame& frame, capture::Sender sender);
    void on_damaged(const DamagedBytes& damaged) override;
    [[nodiscard]] bool repeats_last(const LineFrame& frame,
                                    const capture::SerialPairing::Outcome& outcome) const;
    void begin_request(const LineFrame& frame, const capture::SerialPairing::Outcome& outcome);
    void finish(capture::SerialPairing::Slot slot, Outcome outcome, Bytes response = {},
                Duration response_time = {});
    void give_up(const capture::SerialPairing::Slots& slots, Outcome outcome);

    ListenConfig config_;
    ListenObserver& observer_;
    FrameFinder finder_;
    capture::SerialPairing pairing_;
    std::array<std::optional<SeenRequest>, capture::SerialPairing::kSlots> waiting_;  // by slot
    // The last request on the line.
    wire::Pdu last_pdu_;
    std::uint8_t last_unit_ = 0;
    capture::SerialPairing::Slot last_slot_ = 0;
    Instant last_end_;
    bool last_failed_ = false;  // its time-out has passed
    LineStatistics statistics_;
};

}  // namespace takt::capture
