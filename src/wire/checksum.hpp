// The CRC byte by byte, for the framer.
#pragma once

#include <cstdint>

namespace takt::wire {

inline constexpr std::uint16_t kCrcStart = 0xFFFF;

/// The CRC after one more byte. Over a frame with its CRC the result is 0.
std::uint16_t crc16_next(std::uint16_t crc, std::uint8_t byte);

}  // namespace takt::wire
