// Quantities the specification allows (MODBUS Application Protocol V1.1b3, section 6).
#pragma once

#include <cstddef>
#include <cstdint>

#include "takt/wire/function.hpp"

namespace takt::wire {

inline constexpr std::size_t kMaxReadBits = 2000;
inline constexpr std::size_t kMaxWriteBits = 1968;
inline constexpr std::size_t kMaxReadRegisters = 125;
inline constexpr std::size_t kMaxWriteRegisters = 123;
inline constexpr std::size_t kMaxReadWriteRegisters = 121;  ///< written by 0x17
inline constexpr std::size_t kMaxFifoRegisters = 31;

// File records: requests are a byte count and ranges, each with its reference type.
inline constexpr std::uint8_t kFileReferenceType = 6;
inline constexpr std::size_t kFileRange = 7;           ///< bytes: reference type, file, record, length
inline constexpr std::size_t kMaxFileBytes = 251;      ///< what a byte count can announce in a PDU
inline constexpr std::size_t kMaxFileRegisters = 124;  ///< in one range: its answer has two bytes more

/// The bytes of a range of that length in the response to 0x14.
constexpr std::size_t file_response_bytes(std::size_t registers) {
    return 2 + 2 * registers;
}

/// The greatest number of items in one request; of 0x17 the items read; 0 for functions without items.
std::size_t most_items(Function function);

}  // namespace takt::wire
