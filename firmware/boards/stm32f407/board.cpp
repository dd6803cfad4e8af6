// STM32F407 at 16 MHz of its internal oscillator (Cortex-M4): USART1 on PA9 and PA10, driver enable on PA8.
// Registers: ST RM0090. Built and linked; QEMU has no such board, so this port has not run.
#include "takt/firmware/board.hpp"

#include "takt/firmware/cortex_m.hpp"

namespace takt::firmware::board {
namespace {

constexpr std::uint32_t kHertz = 16'000'000;
constexpr std::uint32_t kResets = 0x40023800;   // RCC
constexpr std::uint32_t kPort = 0x40020000;     // GPIOA
constexpr std::uint32_t kUart = 0x40011000;     // USART1
constexpr std::uint32_t kClock = 0x40000000;    // TIM2
constexpr std::uint32_t kOneShot = 0x40000C00;  // TIM5
constexpr std::uint32_t kFlash = 0x40023C00;

constexpr unsigned kUartInterrupt = 37;
constexpr unsigned kOneShotInterrupt = 50;
constexpr unsigned kDriverPin = 8;

// CR1 of the USART
constexpr std::uint32_t kEnable = 1U << 13U;
constexpr std::uint32_t kNineBits = 1U << 12U;  // with parity
constexpr std::uint32_t kParity = 1U << 10U;
constexpr std::uint32_t kOdd = 1U << 9U;
constexpr std::uint32_t kCompleteInterrupt = 1U << 6U;
constexpr std::uint32_t kReceiveInterrupt = 1U << 5U;
constexpr std::uint32_t kTransmitter = 1U << 3U;
constexpr std::uint32_t kReceiver = 1U << 2U;

constexpr unsigned kFirstSector = 10;
constexpr std::uint32_t kFirstPage = 0x080C0000;
constexpr std::uint32_t kSectorBytes = 0x20000;
constexpr std::size_t kPageWords = 1024;  // of the sector; its rest stays erased
constexpr unsigned kPageCount = 2;

BoardEvents* g_events;

std::uint32_t address_of(unsigned page, std::size_t index) {
    return kFirstPage + page * kSectorBytes + static_cast<std::uint32_t>(index * sizeof(std::uint32_t));
}

void configure_timer(std::uint32_t timer) {
    reg(timer + 0x28) = kHertz / 1'000'000 - 1;
    reg(timer + 0x2C) = ~0U;
    reg(timer + 0x14) = 1;  // loads the prescaler
    reg(timer + 0x10) = 0;
}

// KEYR unlocks; PSIZE 2: 32 bits (2.7 to 3.6 V).
void begin_flash(std::uint32_t control) {
    reg(kFlash + 0x04) = 0x45670123;
    reg(kFlash + 0x04) = 0xCDEF89AB;
    reg(kFlash + 0x10) = 2U << 8U | control;
}

void end_flash() {
    constexpr std::uint32_t kBusy = 1U << 16U;
    constexpr std::uint32_t kLock = 1U << 31U;
    while ((reg(kFlash + 0x0C) & kBusy) != 0) {}
    reg(kFlash + 0x10) = kLock;
}

}  // namespace

std::uint32_t clock() {
    return reg(kClock + 0x24);
}

bool open(const wire::CharacterFormat& format, BoardEvents& events, unsigned port) {
    constexpr std::uint32_t kLeastDivider = 16;
    if (port != 0 || format.data_bits != 8 || kHertz / format.baud < kLeastDivider) return false;
    g_events = &events;
    reg(kResets + 0x30) = reg(kResets + 0x30) | 1U;                   // GPIOA
    reg(kResets + 0x40) = reg(kResets + 0x40) | 1U << 0U | 1U << 3U;  // TIM2, TIM5
    reg(kResets + 0x44) = reg(kResets + 0x44) | 1U << 4U;             // USART1
    if ((reg(kClock) & 1U) == 0) configure_timer(kClock);
    reg(kClock) = 1;
    configure_timer(kOneShot);
    reg(kOneShot + 0x0C) = 1;  // interrupt at the end of the period
    // PA8 output, PA9 and PA10 alternate function 7.
    reg(kPort) = (reg(kPort) & ~(0x3FU << 16U)) | 1U << 16U | 2U << 18U | 2U << 20U;
    reg(kPort + 0x24) = (reg(kPort + 0x24) & ~0xFF0U) | 7U << 4U | 7U << 8U;
    reg(kUart + 0x08) = (kHertz + format.baud / 2) / format.baud;  // BRR
    reg(kUart + 0x10) = format.stop_bits == 2 ? 2U << 12U : 0;
    std::uint32_t control = kEnable | kTransmitter | kReceiver | kReceiveInterrupt;
    if (format.parity != wire::Parity::none) control |= kNineBits | kParity;
    if (format.parity == wire::Parity::odd) control |= kOdd;
    reg(kUart + 0x0C) = control;
    enable_interrupt(kUartInterrupt);
    enable_interrupt(kOneShotInterrupt);
    return true;
}

void send(std::uint8_t character, unsigned) {
    reg(kUart + 0x04) = character;
    reg(kUart) = ~(1U << 6U);  // TC: write 0 to clear
    reg(kUart + 0x0C) = reg(kUart + 0x0C) | kCompleteInterrupt;
}

void start_timer(std::uint32_t microseconds, unsigned port) {
    constexpr std::uint32_t kOnce = 1U << 3U;
    constexpr std::uint32_t kByOverflow = 1U << 2U;  // the update event of EGR sets no flag
    stop_timer(port);
    reg(kOneShot + 0x2C) = microseconds;
    reg(kOneShot) = kByOverflow | kOnce;
    reg(kOneShot + 0x14) = 1;  // the counter begins at 0
    reg(kOneShot) = kByOverflow | kOnce | 1;
}

void stop_timer(unsigned) {
    reg(kOneShot) = 0;
    reg(kOneShot + 0x10) = 0;
}

void drive_line(bool on, unsigned) {
    reg(kPort + 0x18) = on ? 1U << kDriverPin : 1U << (kDriverPin + 16U);
}

std::span<const std::uint32_t> flash_page(unsigned page) {
    if (page >= kPageCount) return {};
    return {reinterpret_cast<const std::uint32_t*>(static_cast<std::uintptr_t>(address_of(page, 0))),
            kPageWords};
}

void erase_page(unsigned page) {
    constexpr std::uint32_t kErase = 1U << 1U;
    constexpr std::uint32_t kStart = 1U << 16U;
    begin_flash(kErase | (kFirstSector + page) << 3U);
    reg(kFlash + 0x10) = reg(kFlash + 0x10) | kStart;
    end_flash();
}

void write_word(unsigned page, std::size_t index, std::uint32_t word) {
    begin_flash(1);  // PG
    reg(address_of(page, index)) = word;
    end_flash();
}

void sleep() {
    wait_for_interrupt();
}

}  // namespace takt::firmware::board

extern "C" {

using namespace takt::firmware;

void uart_interrupt() {
    const std::uint32_t status = reg(board::kUart);
    constexpr std::uint32_t kFaults = 0xF;  // overrun, noise, framing, parity: cleared by reading DR
    if ((status & (1U << 5U | kFaults)) != 0) {
        const auto character = static_cast<std::uint8_t>(reg(board::kUart + 0x04));
        board::g_events->on_character(character, (status & kFaults) != 0);
    }
    if ((status & 1U << 6U) == 0 || (reg(board::kUart + 0x0C) & board::kCompleteInterrupt) == 0) return;
    reg(board::kUart + 0x0C) = reg(board::kUart + 0x0C) & ~board::kCompleteInterrupt;
    board::g_events->on_sent();
}

void one_shot_interrupt() {
    if (take_event(board::kOneShot + 0x10)) board::g_events->on_timer();  // else stopped meanwhile
}

[[gnu::section(".board_vectors"), gnu::used]] constinit const auto board_vectors = board_vectors_of<82>(
    {{board::kUartInterrupt, uart_interrupt}, {board::kOneShotInterrupt, one_shot_interrupt}});

}  // extern "C"
