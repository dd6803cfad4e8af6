// Quantities the specification allows (MODBUS Application Protocol V1.1b3, section 6).
#pragma once

#include <cstddef>

#include "takt/wire/function.hpp"

namespace takt::wire {

inline constexpr std::size_t kMaxReadBits = 2000;
inline constexpr std::size_t kMaxWriteBits = 1968;
inline constexpr std::size_t kMaxReadRegisters = 125;
inline constexpr std::size_t kMaxWriteRegisters = 123;
inline constexpr std::size_t kMaxReadWriteRegisters = 121;  ///< written by 0x17
inline constexpr std::size_t kMaxFifoRegisters = 31;

/// The greatest number of items in one request; of 0x17 the items read; 0 for functions without items.
std::size_t most_items(Function function);

}  // namespace takt::wire
