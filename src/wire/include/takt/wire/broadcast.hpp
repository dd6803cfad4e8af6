// Which requests may be broadcast (MODBUS over Serial Line V1.02, section 2.1).
#pragma once

#include "takt/wire/function.hpp"

namespace takt::wire {

/// Whether a request with that function may be sent to unit 0: it writes, and its response carries no data:
/// the functions whose response repeats the request or its head.
[[nodiscard]] constexpr bool may_be_broadcast(Function function) {
    return properties(function).echoes();
}

}  // namespace takt::wire
