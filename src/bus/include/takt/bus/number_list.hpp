// Lists of numbers and words as they are written in options: "1-10,16", "none,even".
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::bus {

/// Most numbers of a list.
inline constexpr std::size_t kMaxListed = 4096;

/// Reads "1-10,16,20-25". Repeated numbers are dropped; the order is kept.
/// @returns syntax (the part that cannot be read), out_of_range (value, least, greatest),
///          too_long (numbers, kMaxListed). The caller adds the name of the list.
[[nodiscard]] Result<std::vector<std::uint32_t>> parse_numbers(std::string_view text, std::uint32_t least,
                                                               std::uint32_t greatest);

/// Reads "none,even,odd". Repeated words are dropped.
/// @returns syntax (the word that is not known)
[[nodiscard]] Result<std::vector<wire::Parity>> parse_parities(std::string_view text);

}  // namespace takt::bus
