// Notations of the classic numbers in a table of variables (docs/ide-tables.md).
#pragma once

#include <array>
#include <string_view>

namespace takt::model {

inline constexpr std::array<std::string_view, 3> kNotations{"standard", "coils_at_20001", "zero_based"};

}  // namespace takt::model
