// The keys of a file about a microcontroller.
#pragma once

#include "reading/common_fields.hpp"
#include "reading/field_ranges.hpp"
#include "takt/model/fields.hpp"

namespace takt::model {

inline constexpr auto* kClock = between<1000, 1'000'000'000>;
inline constexpr auto* kClockError = between<0, 100'000>;
inline constexpr auto* kMicroamperes = between<0, 1'000'000>;

inline constexpr Field kFirmware[] = {
    kBaudKey,
    kParityKey,
    kStopBitsKey,
    {.key = "core_clock", .kind = Kind::integer, .required = true, .range = kClock},
    {.key = "cycles_per_instruction", .kind = Kind::integer, .range = between<1, 20>},
    {.key = "wakeup_time", .kind = Kind::duration, .required = true, .range = between<0, in_ns(10ms)>},
    {.key = "uart_clock", .kind = Kind::integer, .range = kClock},
    {.key = "uart_clock_ppm", .kind = Kind::integer, .required = true, .range = kClockError},
    {.key = "oversampling", .kind = Kind::integer, .range = between<1, 64>},
    {.key = "divider_steps", .kind = Kind::integer, .range = between<1, 256>},
    {.key = "timer_clock", .kind = Kind::integer, .range = kClock},
    {.key = "timer_clock_ppm", .kind = Kind::integer, .range = kClockError},
    {.key = "timer_bits", .kind = Kind::integer, .range = between<8, 64>},
    {.key = "request_period", .kind = Kind::duration, .required = true, .range = kLongTime},
    {.key = "registers", .kind = Kind::integer, .range = between<1, 125>},
    {.key = "other_exchanges", .kind = Kind::integer, .range = between<0, 1000>},
    {.key = "active_ua_per_mhz", .kind = Kind::integer, .required = true, .range = between<1, 10'000>},
    {.key = "sleep_na", .kind = Kind::integer, .required = true, .range = between<0, 100'000'000>},
    {.key = "uart_na", .kind = Kind::integer, .range = between<0, 100'000'000>},
    {.key = "transceiver_ua", .kind = Kind::integer, .range = kMicroamperes},
    {.key = "driver_ua", .kind = Kind::integer, .range = kMicroamperes},
    {.key = "battery_mah", .kind = Kind::integer, .range = between<1, 1'000'000>},
};

}  // namespace takt::model
