// Which requests make sense to all devices of a line at once (Modbus over serial line 1.02, section 2.1).
#pragma once

#include "takt/wire/function.hpp"

namespace takt::wire {

/// Whether a request with that function may go to unit 0: it writes, and its answer tells nothing new.
[[nodiscard]] constexpr bool may_be_broadcast(Function function) {
    switch (function) {
        case Function::write_single_coil:
        case Function::write_single_register:
        case Function::write_multiple_coils:
        case Function::write_multiple_registers:
        case Function::write_file_record:
        case Function::mask_write_register: return true;
        default: return false;
    }
}

}  // namespace takt::wire
