// Whether a destination takes samples as fast as they are made.
#pragma once

#include <cstdint>
#include <optional>

#include "takt/publish/output_status.hpp"

namespace takt::publish {

/// Compares the samples that are made with those that are delivered, while the window of the destination is
/// full. An output falls behind if what waits has grown in two intervals that follow each other. An interval
/// ends when the cursor moves: with arrays it moves for many samples at once.
class DeliveryPace {
public:
    static constexpr Duration kInterval = std::chrono::seconds(5);  ///< at least

    /// To be called with each status.
    /// @returns samples a second that are made and not delivered; 0: the output does not fall behind
    [[nodiscard]] std::uint64_t note(Instant now, const OutputStatus& status);

private:
    struct Count {
        Instant at;
        OutputSamples samples;
    };

    void end_interval(const Count& end);

    std::optional<Count> begin_;  // of the interval; none: the window is not full
    std::uint64_t delivered_ = 0;
    bool has_grown_ = false;  // in the interval before
    std::uint64_t behind_per_s_ = 0;
};

}  // namespace takt::publish
