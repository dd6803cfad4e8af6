// Which requests make sense to all devices of a line at once (Modbus over serial line 1.02, section 2.1).
#pragma once

#include "takt/wire/function.hpp"

namespace takt::wire {

/// Whether a request with that function may go to unit 0: it writes, and its answer tells nothing new.
[[nodiscard]] constexpr bool may_be_broadcast(Function function) {
    return properties(function).broadcast;
}

}  // namespace takt::wire
