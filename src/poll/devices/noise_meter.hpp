// Noise before the responses of one device.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "takt/bus/counters.hpp"
#include "takt/poll/noise_finding.hpp"

namespace takt::poll {

/// Finds out whether a device has noise before its responses for good: before at least three of them, and
/// before one in a hundred. A single glitch is only counted (bus::TransactionCounters). One owner, one
/// thread. Never allocates.
class NoiseMeter {
public:
    /// A transaction has ended.
    /// @param bytes     of noise before its response; 0: none
    /// @param counters  of the device, with this transaction
    /// @returns whether there is a finding for the first time
    [[nodiscard]] bool add(std::uint32_t bytes, const bus::TransactionCounters& counters);
    [[nodiscard]] const std::optional<NoiseFinding>& finding() const { return finding_; }

private:
    std::uint32_t least_ = std::numeric_limits<std::uint32_t>::max();  // bytes before a noisy response
    std::uint32_t most_ = 0;
    std::optional<NoiseFinding> finding_;
};

}  // namespace takt::poll
