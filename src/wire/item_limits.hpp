// Quantities of file records and queues (MODBUS Application Protocol V1.1b3, sections 6.14, 6.15, 6.18).
// Those of items are in the table of functions (function.hpp).
#pragma once

#include <cstddef>
#include <cstdint>

namespace takt::wire {

inline constexpr std::size_t kMaxFifoRegisters = 31;

// Requests are a byte count and ranges, each with its reference type.
inline constexpr std::uint8_t kFileReferenceType = 6;
inline constexpr std::size_t kFileRange = 7;           ///< bytes: reference type, file, record, length
inline constexpr std::size_t kMaxFileBytes = 251;      ///< what a byte count can announce in a PDU
inline constexpr std::size_t kMaxFileRegisters = 124;  ///< in one range: its answer has two bytes more

/// The bytes of a range of that length in the response to 0x14.
constexpr std::size_t file_response_bytes(std::size_t registers) {
    return 2 + 2 * registers;
}

}  // namespace takt::wire
