// The main loop of a device.
#pragma once

#include "takt/firmware/board.hpp"
#include "takt/firmware/cortex_m.hpp"
#include "takt/firmware/serial_device.hpp"

namespace takt::firmware {

/// Answers requests and sleeps between them. Never returns.
[[noreturn]] inline void run(SerialDevice& device) {
    for (;;) {
        while (device.work()) {}
        const InterruptLock lock;
        if (!device.has_work()) board::sleep();
    }
}

}  // namespace takt::firmware
