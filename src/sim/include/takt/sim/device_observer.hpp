// What really happened in the devices: the truth that a judge compares values with.
#pragma once

#include <cstdint>
#include <span>

#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/function.hpp"

namespace takt::sim {

/// Items of one device. Bits are given as 0 and 1.
struct DeviceItems {
    Instant time;
    UnitId unit;
    wire::Area area = wire::Area::holding_register;
    std::uint16_t start = 0;                ///< address on the wire
    std::span<const std::uint16_t> values;  ///< valid during the call
    bool broadcast = false;                 ///< of a write
};

/// Told in the order in which things happen, from inside the devices; must not call anything of the
/// simulation. Faults on the way of a request or an answer change nothing of what is told here: a read that
/// was served may never reach the master, or reach it damaged.
class DeviceObserver {
public:
    /// The device gave these values in an answer. `time` is the moment it looked at them: the end of the
    /// request.
    virtual void on_read(const DeviceItems& items) = 0;
    /// The device executed a write; these are its values now. Repeated writes are told each time.
    virtual void on_write(const DeviceItems& items) = 0;
    /// Values became these by themselves: moved, set by Device::change(), or forgotten in a reboot. Values
    /// that follow a Pattern are looked at when they are asked for, and told then; what a
    /// ValueSource gives is not told.
    virtual void on_change(const DeviceItems& items) = 0;

protected:
    ~DeviceObserver() = default;
};

}  // namespace takt::sim
