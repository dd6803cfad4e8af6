// Words beside the numbers of a variable (docs/device-templates.md).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "takt/model/device.hpp"

namespace takt::model {

/// The word of that number, else the names of its set bits, joined by commas. Empty if there is none. Bits of
/// a signed number are those of its two's complement.
[[nodiscard]] std::string words_of(const Variable& variable, std::int64_t number);

/// `0=off, 1=on`, as in the cell of a table.
[[nodiscard]] std::string text_of(const std::vector<ValueWord>& words);

}  // namespace takt::model
