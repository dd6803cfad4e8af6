// Broadcasts (MODBUS over Serial Line V1.02).
#pragma once

#include "takt/base/time.hpp"
#include "takt/wire/function.hpp"

namespace takt::wire {

/// A broadcast has no response: the line then stays silent, so that each device can take it in
/// (section 2.4.1: 100 to 200 ms).
inline constexpr Duration kBroadcastTurnaround = std::chrono::milliseconds(100);

/// Whether a request with that function may be sent to unit 0: it writes, and its response carries no data
/// (section 2.1): the functions whose response repeats the request or its head.
[[nodiscard]] constexpr bool may_be_broadcast(Function function) {
    return properties(function).echoes();
}

}  // namespace takt::wire
