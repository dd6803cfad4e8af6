// Numbers in network order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "takt/base/engine.hpp"

namespace takt::capture {

/// @param at  of its first byte; the number is inside of `bytes`
[[nodiscard]] inline std::uint16_t be16_at(Bytes bytes, std::size_t at) {
    return static_cast<std::uint16_t>(bytes[at] << 8U | bytes[at + 1]);
}
[[nodiscard]] inline std::uint32_t be32_at(Bytes bytes, std::size_t at) {
    return std::uint32_t{be16_at(bytes, at)} << 16U | be16_at(bytes, at + 2);
}

/// Appends the lowest 16 bits.
inline void put_be16(std::string& out, std::size_t number) {
    out += static_cast<char>((number >> 8U) & 0xFFU);
    out += static_cast<char>(number & 0xFFU);
}
inline void put_be32(std::string& out, std::uint32_t number) {
    put_be16(out, number >> 16U);
    put_be16(out, number);
}

}  // namespace takt::capture
