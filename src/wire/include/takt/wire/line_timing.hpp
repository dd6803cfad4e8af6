// Character times and silences of a serial line (MODBUS over Serial Line V1.02, sections 2.5.1.1
// and 2.5.2.1).
#pragma once

#include <cstddef>
#include <cstdint>

#include "takt/base/time.hpp"

namespace takt::wire {

enum class Parity : std::uint8_t { none, even, odd };

/// How one character goes over the line.
struct CharacterFormat {
    std::uint32_t baud = 19200;  ///< bit/s, 1..; 0 means "no serial line": every time is zero
    std::uint8_t data_bits = 8;  ///< RTU 8, ASCII 7
    Parity parity = Parity::even;
    std::uint8_t stop_bits = 1;  ///< 1 or 2

    /// Start bit, data bits, parity and stop bits: 8N1 10, 8E1 11, 8N2 11, 7E1 10.
    [[nodiscard]] constexpr int bits() const {
        return 1 + data_bits + (parity == Parity::none ? 0 : 1) + stop_bits;
    }

    friend constexpr bool operator==(CharacterFormat, CharacterFormat) = default;
};

/// Time of `characters` on the line, computed from exact bit times and rounded up once to a nanosecond.
Duration transmission_time(const CharacterFormat& format, std::size_t characters);

/// Longest pause allowed inside an RTU frame: 1.5 characters, 750 us above 19200 bit/s. Zero without a line.
Duration t1_5(const CharacterFormat& format);

/// Least silence between RTU frames: 3.5 characters, 1750 us above 19200 bit/s. Zero without a line.
Duration t3_5(const CharacterFormat& format);

/// A serial line: how often a master makes sure that a unit which it asks without pause answers the last
/// request (docs/decisions/0039-surplus-responses.md).
inline constexpr Duration kStepCheckInterval = std::chrono::seconds(1);

}  // namespace takt::wire
