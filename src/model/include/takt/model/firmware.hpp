// A slave on a microcontroller, as the file of `takt check --firmware` describes it (docs/firmware.md).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/model/document.hpp"
#include "takt/model/findings.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::model {

/// Clocks in Hz, their greatest errors in parts per million.
struct Firmware {
    wire::CharacterFormat format;  ///< of an RTU line

    std::uint32_t core_clock = 1;
    std::uint32_t cycles_per_instruction = 2;  ///< on average, with the waits for the flash
    Duration wakeup_time{};                    ///< from an interrupt to its first instruction

    std::uint32_t uart_clock = 1;  ///< that is divided to the bit rate
    std::uint32_t uart_clock_ppm = 0;
    std::uint32_t oversampling = 16;  ///< cycles of the divided clock in a bit
    std::uint32_t divider_steps = 1;  ///< between a divider and the next whole one

    std::uint32_t timer_clock = 1'000'000;  ///< of the timer that measures silences
    std::uint32_t timer_clock_ppm = 0;
    std::uint32_t timer_bits = 32;

    Duration request_period{};          ///< between the requests that it answers
    std::uint32_t registers = 1;        ///< that each of them reads
    std::uint32_t other_exchanges = 0;  ///< of other devices, of the same length, in that time

    std::uint32_t active_ua_per_mhz = 0;
    std::uint32_t sleep_na = 0;        ///< with what must run while it sleeps, but the UART
    std::uint32_t uart_na = 0;         ///< of the UART
    std::uint32_t transceiver_ua = 0;  ///< of the line's transceiver while it receives
    std::uint32_t driver_ua = 0;       ///< more, while it sends
    std::optional<std::uint32_t> battery_mah;
};

/// Valid if no finding is an error.
struct CheckedFirmware {
    Firmware firmware;
    std::vector<Finding> findings;
};

/// Reads a document with the keys of Object::firmware.
[[nodiscard]] CheckedFirmware interpret_firmware(const Document& document);

}  // namespace takt::model
