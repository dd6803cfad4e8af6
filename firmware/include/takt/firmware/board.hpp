// What the slave needs of a board. Each folder of firmware/boards implements it (docs/firmware.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "takt/wire/line_timing.hpp"

namespace takt::firmware {

/// Called by interrupt handlers of the board, all of one priority: none interrupts another one.
class BoardEvents {
public:
    /// A character was received; the call follows the end of its stop bit at once.
    /// @param damaged  its parity or stop bit was wrong, or a character before it was lost
    virtual void on_character(std::uint8_t character, bool damaged) = 0;
    /// The character of board::send() has left the line: its stop bit has ended.
    virtual void on_sent() = 0;
    /// The time of board::start_timer() has passed.
    virtual void on_timer() = 0;

protected:
    ~BoardEvents() = default;
};

/// Six parts: clock, UART, timer, driver enable, flash and sleep. No function blocks, except those of the
/// flash. Each serial port has its own UART, timer and driver. Port 0 is there on every board.
namespace board {

/// A free-running clock in microseconds; it wraps around at 2^32. Ticks must not be counted: interrupts can
/// be late. Called by the main loop, also with interrupts masked, and by interrupts, which may interrupt it.
[[nodiscard]] std::uint32_t clock();

/// Opens the UART of a port, and enables the interrupts. May be called again with another format, while no
/// character is sent; the clock goes on.
/// @param events  outlives the program
/// @returns false: there is no such port, or its UART has no such format; nothing was changed
[[nodiscard]] bool open(const wire::CharacterFormat& format, BoardEvents& events, unsigned port = 0);
/// Sends a character; on_sent() follows. Not before on_sent() of the last one.
void send(std::uint8_t character, unsigned port = 0);

/// Calls on_timer() once, `microseconds` after the call, at most 10 us late; replaces the time before.
/// Above 2 minutes the call may come earlier: masters and TcpDevice ask for up to 10 minutes.
void start_timer(std::uint32_t microseconds, unsigned port = 0);
void stop_timer(unsigned port = 0);

/// RS-485: switches the driver of the line on or off. A board without such a driver does nothing.
void drive_line(bool on, unsigned port = 0);

/// Pages of flash, erased to ones: 0 and 1 for retained registers, 2 and 3 for request tables. Two that
/// belong together have one size. Those that a board does not have are empty. The spans are read in place.
[[nodiscard]] std::span<const std::uint32_t> flash_page(unsigned page);
/// All words become 0xFFFFFFFF. Interrupts may be late by the time that it takes.
void erase_page(unsigned page);
/// @pre  the word is 0xFFFFFFFF
void write_word(unsigned page, std::size_t index, std::uint32_t word);

/// Waits for an interrupt. Called with interrupts masked: returns with the pending interrupt not yet handled.
void sleep();

}  // namespace board
}  // namespace takt::firmware
