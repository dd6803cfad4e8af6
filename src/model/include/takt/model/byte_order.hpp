// The byte order of a value as a permutation: the bytes are numbered from the least significant one, 1, and
// listed as on the wire (docs/specification.md, section 2). `2143` is low register first, high byte first.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "takt/base/data_type.hpp"

namespace takt::model {

/// The permutations that two switches can express: of two registers, of one, of four.
inline constexpr std::array<std::string_view, 10> kByteOrders{
    "2143", "4321", "1234", "3412", "21", "12", "21436587", "87654321", "12345678", "78563412"};

/// A permutation as read.
struct Permutation {
    ByteOrder order;        ///< of one register: with the default order of registers
    std::size_t bytes = 4;  ///< 2, 4 or 8
};

/// Reads a permutation; spaces do not count (`2 1 4 3`). Letters name the bytes from the most significant
/// one: `CDAB` is 2143. Nothing if it is not in kByteOrders.
[[nodiscard]] std::optional<Permutation> parse_byte_order(std::string_view text);

/// The permutation of a value with that order. A string, like a value of one register, has two bytes: its
/// registers are always in the order of the text.
/// @param registers  1, 2 or 4
[[nodiscard]] std::string_view byte_order_text(ByteOrder order, int registers);
[[nodiscard]] std::string_view byte_order_text(ByteOrder order, DataType type);

/// A permutation of kByteOrders in letters, A for the most significant byte: `2143` is CDAB.
[[nodiscard]] std::string byte_order_name(std::string_view permutation);

}  // namespace takt::model
