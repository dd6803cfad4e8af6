// Distinct types for numbers of distinct meaning.
#pragma once

#include <compare>
#include <cstdint>

namespace takt {

/// Unit address on the wire, 0..255. 0 is broadcast on serial lines; over TCP 0 and 255 are the server
/// itself.
struct UnitId {
    std::uint8_t value = 0;
    friend constexpr auto operator<=>(UnitId, UnitId) = default;
};
inline constexpr UnitId kBroadcast{0};

/// Zero-based number of a register or a coil on the wire, 0..65535.
struct DataAddress {
    std::uint16_t value = 0;
    friend constexpr auto operator<=>(DataAddress, DataAddress) = default;
};

}  // namespace takt
