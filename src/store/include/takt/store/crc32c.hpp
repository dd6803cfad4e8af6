// The checksum of files that are written in place.
#pragma once

#include <cstddef>
#include <cstdint>

#include "takt/base/engine.hpp"

namespace takt::store {

inline constexpr std::size_t kCrc32cBytes = 4;

/// CRC-32C (Castagnoli: RFC 3720, appendix B.4) of `bytes`, continuing from `before`, the checksum of
/// preceding bytes.
[[nodiscard]] std::uint32_t crc32c(Bytes bytes, std::uint32_t before = 0);

}  // namespace takt::store
