// Observes the true contents of the devices, so that a judge can check values.
#pragma once

#include <cstdint>
#include <span>

#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/function.hpp"

namespace takt::sim {

/// Items of one device. Bits are 0 or 1.
struct DeviceItems {
    Instant time;
    UnitId unit;
    wire::Area area = wire::Area::holding_register;
    std::uint16_t start = 0;                ///< address on the wire
    std::span<const std::uint16_t> values;  ///< valid during the call
    bool broadcast = false;                 ///< of a write
};

/// Called in the order of the events, from inside the devices; must not call the simulation. Faults on the
/// way of a request or an answer do not show here: an answered read may never reach the master, or reach it
/// damaged.
class DeviceObserver {
public:
    /// The device answered a read with these values. `time` is the instant when it read them: the end of the
    /// request.
    virtual void on_read(const DeviceItems& items) = 0;
    /// The device executed a write with these new values. Repeated writes are reported each time.
    virtual void on_write(const DeviceItems& items) = 0;
    /// Values changed without a write: by a pattern, by Device::change(), or by a reboot. Patterns are
    /// evaluated on access and reported then. Values of a ValueSource are not reported.
    virtual void on_change(const DeviceItems& items) = 0;

protected:
    ~DeviceObserver() = default;
};

}  // namespace takt::sim
