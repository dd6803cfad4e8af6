// When an RS-485 driver that is switched by RTS returns to receiving.
#pragma once

#include <cstddef>
#include <optional>

#include "takt/base/time.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::line {

/// Computes when the last stop bit has left the port. Switching earlier would cut off the frame; switching
/// much later would miss the response, which may come after t3.5.
///
/// The end is computed from the bit rate. Then the port's transmitter is polled until it is empty. A port
/// that cannot report this (USB adapters) gets 1 ms for its own delay, less than the smallest t3.5 of 1.75
/// ms. Pure: one owner, time given by the caller.
class DirectionSwitch {
public:
    explicit DirectionSwitch(const wire::CharacterFormat& format) : format_(format) {}

    /// The port accepted `bytes` at `t`. They follow the bytes that it still sends.
    void sent(Instant t, std::size_t bytes);

    /// When to poll the transmitter and call release(); kNever while receiving.
    [[nodiscard]] Instant next_check() const { return next_check_; }

    /// @param empty  whether the transmitter is empty; nothing: the port cannot report it
    /// @returns true: switch to receiving now; false: not yet, see next_check()
    [[nodiscard]] bool release(Instant t, std::optional<bool> empty);

private:
    static constexpr Duration kAdapterDelay = std::chrono::milliseconds(1);
    // Beyond the computed end; then the port is stuck.
    static constexpr Duration kLongestWait = std::chrono::seconds(1);

    wire::CharacterFormat format_;
    Instant end_{};
    Instant next_check_ = kNever;
};

}  // namespace takt::line
