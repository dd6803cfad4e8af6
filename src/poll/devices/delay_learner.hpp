// The response times of one device: its turnaround, how late its late responses were, and the time-out that
// follows from both (docs/planning.md, "Measured response times").
#pragma once

#include <cstdint>
#include <optional>

#include "devices/compact_times.hpp"
#include "takt/base/time.hpp"
#include "takt/model/device.hpp"
#include "takt/poll/delay_finding.hpp"

namespace takt::poll {

/// Measures a device, beginning with what earlier runs have measured (Device::times).
///
/// A delay is the time from the end of the request, computed from the bit rate, to the first byte of the
/// response, computed from the arrival of its last byte and its length. Over TCP it is the time from sending
/// to arrival. A delay below zero counts as zero: a pty delivers bytes faster than the bit rate allows.
///
/// One owner, one thread. The constructor, learnt() and assignment allocate; on_response() does where the
/// delay is shorter or longer than all before by a power of two.
class DelayLearner {
public:
    /// A device that is never measured.
    DelayLearner() = default;

    /// @param wait   time-out of its requests, up to the first byte of the response
    /// @param grows  the time-out is derived from what is measured: it grows with it, and never shrinks
    /// The device must outlive it.
    DelayLearner(const model::Device& device, Duration wait, bool grows);

    /// A request was sent, and has ended with a response or without one.
    void on_attempt() { ++measured_.attempts; }

    /// A response within the time-out.
    /// @param tolerated  a longer delay contradicts the turnaround that the project states, if it does
    /// @returns a finding that is new, or whose advised value has grown
    std::optional<DelayFinding> on_response(Duration delay, Duration tolerated);

    /// A response after its transaction had ended.
    /// @param waited  time-out of that transaction
    /// @returns as on_response()
    std::optional<DelayFinding> on_late(Duration delay, Duration waited);

    /// The time-out of the next request.
    [[nodiscard]] Duration wait() const { return wait_; }
    /// The longest delay of a late response, over all runs; zero: none was late.
    [[nodiscard]] Duration lateness() const { return measured_.lateness; }
    /// The device is slower than a setting says, also if only an earlier run has seen it.
    [[nodiscard]] const std::optional<DelayFinding>& finding() const { return finding_; }

    [[nodiscard]] model::MeasuredTimes measured() const;
    [[nodiscard]] model::LearntTimes learnt() const;

    /// Whether since the last call something was measured that is worth keeping: a late response, or for
    /// `turnaround: learn` a longer one.
    [[nodiscard]] bool take_news();

    /// Continues what `old` has measured, of the same device in an earlier version of the project.
    /// @param same_settings  its finding still holds
    void take_over(const DelayLearner& old, bool same_settings);

private:
    void grow();
    std::optional<DelayFinding> note_late(Duration delay, Duration waited);
    /// @param seen  which such responses came
    std::optional<DelayFinding> note(DelayFinding found, const model::MeasuredTimes& seen);

    const model::Device* device_ = nullptr;
    Duration wait_{};
    bool grows_ = false;
    bool news_ = false;
    std::uint8_t slow_ones_ = 0;     // the last eight responses, one bit each: later than the turnaround
    model::MeasuredTimes measured_;  // attempts and what was late; the rest is in times_
    model::MeasuredTimes slower_;    // than the turnaround, in this run: late, lateness, next_latest
    CompactLatencyStatistics times_;
    std::optional<DelayFinding> finding_;
};

}  // namespace takt::poll
