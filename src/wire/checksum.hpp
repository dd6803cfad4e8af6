// The CRC byte by byte, for the framer.
#pragma once

#include <cstdint>

namespace takt::wire {

inline constexpr std::uint16_t kCrcStart = 0xFFFF;

/// The CRC of the bytes so far and one more. Over a frame with its own CRC it comes out as 0.
std::uint16_t crc16_next(std::uint16_t crc, std::uint8_t byte);

}  // namespace takt::wire
