// The main loop of a device.
#pragma once

#include "takt/firmware/board.hpp"
#include "takt/firmware/cortex_m.hpp"

namespace takt::firmware {

/// Works and sleeps in between. Never returns.
/// @tparam Device  SerialDevice, TcpDevice or EnginePort
template <class Device>
[[noreturn]] void run(Device& device) {
    for (;;) {
        while (device.work()) {}
        const InterruptLock lock;
        if (!device.has_work()) board::sleep();
    }
}

}  // namespace takt::firmware
