// TI LM3S6965 evaluation board (Cortex-M3) at 20 MHz: UART0 on PA0 and PA1, driver enable on PC5. Registers:
// LM3S6965 data sheet. QEMU cannot write its flash: the functions of the flash have not run.
#include "takt/firmware/board.hpp"

#include <algorithm>

#include "takt/firmware/cortex_m.hpp"

namespace takt::firmware::board {
namespace {

constexpr std::uint32_t kFlash = 0x400FD000;
constexpr std::uint32_t kSystem = 0x400FE000;
constexpr std::uint32_t kSerialPort = 0x40004000;  // GPIO A
constexpr std::uint32_t kDriverPort = 0x40006000;  // GPIO C
constexpr std::uint32_t kUart = 0x4000C000;        // PL011
constexpr std::uint32_t kOneShot = 0x40030000;     // timer 0
constexpr std::uint32_t kSending = 0x40031000;     // timer 1
constexpr std::uint32_t kClock = 0x40032000;       // timer 2
constexpr std::uint32_t kSysTick = 0xE000E010;

constexpr unsigned kUartInterrupt = 5;
constexpr unsigned kOneShotInterrupt = 19;
constexpr unsigned kSendingInterrupt = 21;
constexpr unsigned kClockInterrupt = 23;
constexpr unsigned kDriverPin = 5;

constexpr std::uint32_t kHertz = 20'000'000;
constexpr std::uint32_t kTicks = kHertz / 1'000'000;  // in a microsecond
constexpr std::uint32_t kSixteenth = kHertz / 16;  // ticks of a sixteenth of a bit: divide by the baud rate
constexpr std::uint32_t kSysTickMask = 0xFFFFFF;   // 0.84 s

// Modes of a timer
constexpr std::uint32_t kOnce = 1;
constexpr std::uint32_t kPeriodic = 2;

constexpr std::uint32_t kPageWords = 256;
constexpr std::uint32_t kPages = 0x3F800;  // the last two
constexpr unsigned kPageCount = 2;

BoardEvents* g_events;
std::uint32_t g_character_ticks;
std::uint32_t g_sixteenth_ticks;
// The time at the last interrupt of timer 2, which alone stores it.
volatile std::uint32_t g_clock_ticks;  // of SysTick
volatile std::uint32_t g_microseconds;

void set_bits(std::uint32_t address, std::uint32_t bits) {
    reg(address) = reg(address) | bits;
}

std::uint32_t passed_ticks() {
    return (g_clock_ticks - reg(kSysTick + 0x08)) & kSysTickMask;  // it counts down
}

// SysTick; the core and the UART at 20 MHz: the PLL (200 MHz) divided by 10, from the crystal of 8 MHz.
void start_clocks() {
    constexpr std::uint32_t kRate = 9U << 23U | 1U << 22U | 0xEU << 6U;  // SYSDIV, USESYSDIV, XTAL
    constexpr std::uint32_t kBypass = 1U << 11U;
    constexpr std::uint32_t kCrystalOff = 1U << 0U;
    constexpr std::uint32_t kLocked = 1U << 6U;
    constexpr std::uint32_t kCrystalStart = 0x180000;  // ticks
    reg(kSysTick + 0x04) = kSysTickMask;
    reg(kSysTick + 0x08) = 0;
    reg(kSysTick) = 1U << 2U | 1;                     // from the clock of the core
    set_bits(kSystem + 0x104, 1U << 0U | 7U << 16U);  // UART0, timers 0 to 2
    set_bits(kSystem + 0x108, 1U << 0U | 1U << 2U);   // GPIO A, C
    reg(kSystem + 0x060) = (reg(kSystem + 0x060) | kBypass) & ~kCrystalOff;
    while (passed_ticks() < kCrystalStart) {}
    reg(kSystem + 0x060) = kRate | kBypass;
    while ((reg(kSystem + 0x050) & kLocked) == 0) {}
    reg(kSystem + 0x060) = kRate;
    reg(kSystem + 0x140) = kTicks - 1;  // for the flash
}

void stop(std::uint32_t timer) {
    reg(timer + 0x0C) = 0;
    reg(timer + 0x24) = 1;  // the interrupt
}

void start(std::uint32_t timer, std::uint32_t ticks) {
    stop(timer);
    reg(timer + 0x28) = ticks;
    reg(timer + 0x0C) = 1;
}

void configure_timer(std::uint32_t timer, std::uint32_t mode, unsigned interrupt) {
    stop(timer);
    reg(timer) = 0;  // 32 bits
    reg(timer + 0x04) = mode;
    reg(timer + 0x18) = 1;
    enable_interrupt(interrupt);
}

// false: the timer was stopped after its interrupt had become pending.
bool take_interrupt(std::uint32_t timer) {
    const bool pending = (reg(timer + 0x20) & 1U) != 0;
    reg(timer + 0x24) = 1;
    return pending;
}

}  // namespace

// The clock is SysTick, because QEMU cannot read the counters of the timers. Timer 2 interrupts twice a
// second and stores the time, before SysTick wraps around. If it does so inside of this function, the time is
// read again.
std::uint32_t clock() {
    for (;;) {
        const std::uint32_t before = g_microseconds;
        const std::uint32_t now = before + passed_ticks() / kTicks;
        if (before == g_microseconds) return now;
    }
}

bool open(const wire::CharacterFormat& format, BoardEvents& events, unsigned port) {
    constexpr std::uint32_t kSixtyFourths = kHertz / 16 * 64;
    const std::uint32_t divider = (kSixtyFourths + format.baud / 2) / format.baud;
    if (port != 0 || divider < 64 || divider >> 22U != 0) return false;
    g_events = &events;
    if ((reg(kSysTick) & 1U) == 0) {
        start_clocks();
        configure_timer(kClock, kPeriodic, kClockInterrupt);
        start(kClock, kHertz / 2);
    }
    configure_timer(kOneShot, kOnce, kOneShotInterrupt);
    configure_timer(kSending, kOnce, kSendingInterrupt);
    g_sixteenth_ticks = kSixteenth / format.baud;
    // A sixteenth more: the character begins with the next tick of the UART.
    g_character_ticks = (16U * static_cast<std::uint32_t>(format.bits()) + 1) * kSixteenth / format.baud;
    set_bits(kDriverPort + 0x400, 1U << kDriverPin);  // output
    set_bits(kDriverPort + 0x51C, 1U << kDriverPin);
    set_bits(kSerialPort + 0x420, 3);
    set_bits(kSerialPort + 0x51C, 3);
    reg(kUart + 0x30) = 0;
    reg(kUart + 0x24) = divider / 64;
    reg(kUart + 0x28) = divider % 64;
    // No FIFO: it would report characters later.
    std::uint32_t control = (format.data_bits - 5U) << 5U | (format.stop_bits - 1U) << 3U;
    if (format.parity != wire::Parity::none) control |= 1U << 1U;
    if (format.parity == wire::Parity::even) control |= 1U << 2U;
    reg(kUart + 0x2C) = control;
    reg(kUart + 0x38) = 1U << 4U;                        // interrupt: received
    reg(kUart + 0x30) = 1U << 0U | 1U << 8U | 1U << 9U;  // on, transmitter, receiver
    enable_interrupt(kUartInterrupt);
    return true;
}

// The UART interrupts when its data register is free, not after the stop bit: timer 1 measures the character.
void send(std::uint8_t character, unsigned) {
    reg(kUart) = character;
    start(kSending, g_character_ticks);
}

void start_timer(std::uint32_t microseconds, unsigned) {
    start(kOneShot, std::min(microseconds, ~0U / kTicks) * kTicks);
}

void stop_timer(unsigned) {
    stop(kOneShot);
}

void drive_line(bool on, unsigned) {
    reg(kDriverPort + (4U << kDriverPin)) = on ? 1U << kDriverPin : 0;  // the address has the mask
}

std::span<const std::uint32_t> flash_page(unsigned page) {
    if (page >= kPageCount) return {};
    const std::uintptr_t address = kPages + page * kPageWords * sizeof(std::uint32_t);
    return {reinterpret_cast<const std::uint32_t*>(address), kPageWords};
}

void erase_page(unsigned page) {
    constexpr std::uint32_t kErase = 2;
    reg(kFlash) = kPages + page * kPageWords * sizeof(std::uint32_t);
    reg(kFlash + 0x08) = 0xA442U << 16U | kErase;
    while ((reg(kFlash + 0x08) & kErase) != 0) {}
}

void write_word(unsigned page, std::size_t index, std::uint32_t word) {
    constexpr std::uint32_t kWrite = 1;
    reg(kFlash) = kPages + (page * kPageWords + index) * sizeof word;
    reg(kFlash + 0x04) = word;
    reg(kFlash + 0x08) = 0xA442U << 16U | kWrite;
    while ((reg(kFlash + 0x08) & kWrite) != 0) {}
}

void sleep() {
    wait_for_interrupt();
}

}  // namespace takt::firmware::board

extern "C" {

using namespace takt::firmware;

void uart_interrupt() {
    constexpr std::uint32_t kEmpty = 1U << 4U;
    constexpr std::uint32_t kFaults = 0xF00;  // framing, parity, break, overrun
    while ((reg(board::kUart + 0x18) & kEmpty) == 0) {
        const std::uint32_t data = reg(board::kUart);
        board::g_events->on_character(static_cast<std::uint8_t>(data), (data & kFaults) != 0);
    }
}

void one_shot_interrupt() {
    if (board::take_interrupt(board::kOneShot)) board::g_events->on_timer();
}

void sending_interrupt() {
    constexpr std::uint32_t kBusy = 1U << 3U;
    if (!board::take_interrupt(board::kSending)) return;
    if ((reg(board::kUart + 0x18) & kBusy) != 0)
        board::start(board::kSending, board::g_sixteenth_ticks);
    else
        board::g_events->on_sent();
}

void clock_interrupt() {
    if (!board::take_interrupt(board::kClock)) return;
    const std::uint32_t passed = board::passed_ticks() / board::kTicks;
    board::g_clock_ticks = (board::g_clock_ticks - passed * board::kTicks) & board::kSysTickMask;
    board::g_microseconds = board::g_microseconds + passed;
}

[[gnu::section(".board_vectors"), gnu::used]] constinit const auto board_vectors =
    board_vectors_of<44>({{board::kUartInterrupt, uart_interrupt},
                          {board::kOneShotInterrupt, one_shot_interrupt},
                          {board::kSendingInterrupt, sending_interrupt},
                          {board::kClockInterrupt, clock_interrupt}});

}  // extern "C"
