// A character of a serial line.
#pragma once

#include <cstdint>

namespace takt::wire {

/// A character as a UART received it.
struct Character {
    std::uint8_t value = 0;
    bool faulty = false;  ///< its parity or its stop bit was wrong

    friend constexpr bool operator==(Character, Character) = default;
};

}  // namespace takt::wire
