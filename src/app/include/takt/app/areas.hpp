// The four areas as the command line names them.
#pragma once

#include <string_view>

#include "takt/wire/function.hpp"

namespace takt::app {

/// "coils", "discrete", "input", "holding".
[[nodiscard]] std::string_view area_word(wire::Area area);

/// 0x01..0x04.
[[nodiscard]] wire::Function read_function(wire::Area area);

}  // namespace takt::app
