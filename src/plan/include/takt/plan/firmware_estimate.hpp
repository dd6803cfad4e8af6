// What the clocks of a microcontroller allow on a line, and the current of a slave that sleeps between
// characters (docs/firmware.md, "Low power").
#pragma once

#include <cstdint>
#include <optional>

#include "takt/base/time.hpp"
#include "takt/model/firmware.hpp"

namespace takt::plan {

/// What an exchange costs a slave that sleeps between characters.
struct ExchangeCost {
    std::uint32_t interrupts = 0;  ///< each wakes the core: a character received or sent, the end of a frame
    std::uint32_t instructions = 0;
};

/// Cycles that a Cortex-M0 takes for entry and exit of an interrupt (Cortex-M0 Technical Reference Manual).
inline constexpr std::uint32_t kInterruptCycles = 32;

/// A request that reads `registers`, and its response. Measured with the image `microbit_instrument`;
/// tests/firmware/power_test.py compares.
[[nodiscard]] ExchangeCost own_exchange(std::uint32_t registers);
/// The same exchange with another device of the line, which the slave receives and ignores.
[[nodiscard]] ExchangeCost foreign_exchange(std::uint32_t registers);

/// A deviation and the greatest one with which the line works.
struct Deviation {
    double greatest = 0;
    double allowed = 0;
    [[nodiscard]] bool holds() const { return greatest <= allowed; }
};

/// A silence as the timer measures it: from the end of a character to that of the next one.
struct MeasuredSilence {
    Duration time{};
    std::uint64_t ticks = 0;
    Deviation deviation;  ///< in seconds; allowed is half a character
};

struct FirmwareEstimate {
    double bit_rate = 0;       ///< with the nearest divider
    double divider = 0;        ///< of the UART's clock, before the oversampling
    double divider_error = 0;  ///< of the bit rate, without that of the clock; a share, with its sign
    /// Of the bit rate, as a share. A receiver samples the last bit of a character in its middle. Both sides
    /// together may be off by half a bit there, less one sample, each by half of that.
    Deviation rate;
    MeasuredSilence t1_5;
    MeasuredSilence t3_5;
    std::uint64_t most_ticks = 0;  ///< of the timer
    Deviation character;           ///< seconds from an interrupt to the next sleep, and of a character
    Deviation line;  ///< seconds that the exchanges of a period take on the line, and the period

    ExchangeCost own;
    ExchangeCost foreign;
    double wakeups = 0;  ///< per second
    double active = 0;   ///< share of the time
    double sending = 0;  ///< share of the time

    // Averages, in microamperes
    double asleep_ua = 0;
    double active_ua = 0;
    double uart_ua = 0;
    double transceiver_ua = 0;
    [[nodiscard]] double current_ua() const { return asleep_ua + active_ua + uart_ua + transceiver_ua; }
    std::optional<double> battery_days;

    [[nodiscard]] bool timer_holds() const { return t3_5.ticks <= most_ticks; }
    [[nodiscard]] bool holds() const {
        return rate.holds() && t1_5.deviation.holds() && t3_5.deviation.holds() && timer_holds() &&
               character.holds() && line.holds();
    }
};

/// @param firmware  without errors
[[nodiscard]] FirmwareEstimate estimate(const model::Firmware& firmware);

}  // namespace takt::plan
