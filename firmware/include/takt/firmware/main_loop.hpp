// The main loop of a device.
#pragma once

#include "takt/firmware/board.hpp"
#include "takt/firmware/cortex_m.hpp"

namespace takt::firmware {

/// Works and sleeps in between. Never returns.
/// @tparam Devices  SerialDevice, TcpDevice, EnginePort, or the like
template <class... Devices>
[[noreturn]] void run(Devices&... devices) {
    for (;;) {
        while ((devices.work() | ...)) {}
        const InterruptLock lock;
        if (!(devices.has_work() || ...)) board::sleep();
    }
}

}  // namespace takt::firmware
