// When the driver of a two-wire RS-485 port that is switched by RTS goes back to receiving.
#pragma once

#include <cstddef>
#include <optional>

#include "takt/base/time.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::line {

/// Follows the bytes given to the port and says when the last stop bit has left it: the driver must not be
/// switched off before, and not much later, since the response may come after t3.5.
///
/// The end is computed from the bit rate; then the port's transmitter is asked whether it is empty. Where
/// it cannot tell (USB adapters), 1 ms is added for the adapter's own delay, less than the least t3.5 of
/// 1.75 ms. Pure: one owner, time given by the caller.
class DirectionSwitch {
public:
    explicit DirectionSwitch(const wire::CharacterFormat& format) : format_(format) {}

    /// The port took `bytes` at `t`; they follow what it is still sending.
    void sent(Instant t, std::size_t bytes);

    /// When to ask the transmitter and call release(); kNever while receiving.
    [[nodiscard]] Instant next_check() const { return next_check_; }

    /// @param empty  what the transmitter says; nothing: it cannot tell
    /// @returns true: switch to receiving now. false: not yet, see next_check().
    [[nodiscard]] bool release(Instant t, std::optional<bool> empty);

private:
    static constexpr Duration kAdapterDelay = std::chrono::milliseconds(1);
    static constexpr Duration kLongestWait =
        std::chrono::seconds(1);  // beyond the computed end; then the port is stuck

    wire::CharacterFormat format_;
    Instant end_{};
    Instant next_check_ = kNever;
};

}  // namespace takt::line
