// BBC micro:bit, nRF51822 (Cortex-M0). Registers: nRF51 Series Reference Manual 3.0.
#include "takt/firmware/board.hpp"

#include "takt/firmware/cortex_m.hpp"

namespace takt::firmware::board {
namespace {

constexpr std::uint32_t kUart = 0x40002000;
constexpr std::uint32_t kOneShot = 0x40008000;  // TIMER0
constexpr std::uint32_t kClock = 0x40009000;    // TIMER1
constexpr std::uint32_t kFlash = 0x4001E000;    // NVMC
constexpr std::uint32_t kPort = 0x50000000;     // GPIO

constexpr unsigned kUartInterrupt = 2;
constexpr unsigned kOneShotInterrupt = 8;
constexpr unsigned kTimer2Interrupt = 10;
constexpr std::uint32_t kTransmitPin = 24;
constexpr std::uint32_t kReceivePin = 25;
constexpr std::uint32_t kDriverPin = 3;  // P0.03, pin 0 of the edge connector

constexpr std::uint32_t kPageWords = 256;
constexpr std::uint32_t kPages = 0x3F800;  // the last two
constexpr unsigned kPageCount = 2;

BoardEvents* g_events;
bool g_lost;  // a character was lost or damaged before the next one

void configure_timer(std::uint32_t timer) {
    constexpr std::uint32_t k32Bits = 3;
    constexpr std::uint32_t k1MHz = 4;  // 16 MHz / 2^4
    reg(timer + 0x508) = k32Bits;
    reg(timer + 0x510) = k1MHz;
}

}  // namespace

std::uint32_t clock() {
    reg(kClock + 0x040) = 1;  // capture into CC[0]
    return reg(kClock + 0x540);
}

bool open(const wire::CharacterFormat& format, BoardEvents& events, unsigned port) {
    constexpr std::uint32_t kLeastBaud = 1200;
    constexpr std::uint32_t kMostBaud = 921'600;
    const bool possible = format.data_bits == 8 && format.stop_bits == 1 &&
                          format.parity != wire::Parity::odd && format.baud >= kLeastBaud &&
                          format.baud <= kMostBaud;
    if (port != 0 || !possible) return false;
    g_events = &events;
    configure_timer(kClock);
    reg(kClock) = 1;
    configure_timer(kOneShot);
    reg(kOneShot + 0x200) = 1U << 8U;   // stops at CC[0]
    reg(kOneShot + 0x304) = 1U << 16U;  // interrupt at CC[0]
    reg(kPort + 0x508) = 1U << kTransmitPin;
    reg(kPort + 0x518) = 1U << kTransmitPin | 1U << kDriverPin;
    reg(kUart + 0x50C) = kTransmitPin;
    reg(kUart + 0x514) = kReceivePin;
    // BAUDRATE: rate * 2^32 / 16 MHz = rate * 268.435, the lowest 12 bits rounded.
    const std::uint32_t rate = format.baud * 268 + format.baud * 435 / 1000;
    reg(kUart + 0x524) = (rate + 0x800) & ~0xFFFU;
    reg(kUart + 0x56C) = format.parity == wire::Parity::even ? 7U << 1U : 0;
    reg(kUart + 0x500) = 4;                               // ENABLE
    reg(kUart + 0x304) = 1U << 2U | 1U << 7U | 1U << 9U;  // interrupts: received, sent, error
    reg(kUart + 0x000) = 1;                               // STARTRX
    reg(kUart + 0x008) = 1;                               // STARTTX
    enable_interrupt(kUartInterrupt);
    enable_interrupt(kOneShotInterrupt);
    return true;
}

void send(std::uint8_t character, unsigned) {
    reg(kUart + 0x51C) = character;
}

void start_timer(std::uint32_t microseconds, unsigned) {
    reg(kOneShot + 0x004) = 1;  // stop
    reg(kOneShot + 0x00C) = 1;  // clear
    reg(kOneShot + 0x140) = 0;  // an event that was not handled yet
    reg(kOneShot + 0x540) = microseconds;
    reg(kOneShot + 0x000) = 1;
}

void stop_timer(unsigned) {
    reg(kOneShot + 0x004) = 1;
    reg(kOneShot + 0x140) = 0;
}

void drive_line(bool on, unsigned) {
    reg(kPort + (on ? 0x508 : 0x50C)) = 1U << kDriverPin;
}

std::span<const std::uint32_t> flash_page(unsigned page) {
    if (page >= kPageCount) return {};
    const std::uintptr_t address = kPages + page * kPageWords * sizeof(std::uint32_t);
    return {reinterpret_cast<const std::uint32_t*>(address), kPageWords};
}

// CONFIG: 1 write, 2 erase, 0 read only. The processor waits while the flash works.
void erase_page(unsigned page) {
    reg(kFlash + 0x504) = 2;
    reg(kFlash + 0x508) = kPages + page * kPageWords * sizeof(std::uint32_t);
    while (reg(kFlash + 0x400) == 0) {}
    reg(kFlash + 0x504) = 0;
}

void write_word(unsigned page, std::size_t index, std::uint32_t word) {
    reg(kFlash + 0x504) = 1;
    reg(kPages + (page * kPageWords + index) * sizeof(std::uint32_t)) = word;
    while (reg(kFlash + 0x400) == 0) {}
    reg(kFlash + 0x504) = 0;
}

void sleep() {
    wait_for_interrupt();
}

}  // namespace takt::firmware::board

extern "C" {

using namespace takt::firmware;

void uart_interrupt() {
    constexpr std::uint32_t kReceived = board::kUart + 0x108;
    constexpr std::uint32_t kSent = board::kUart + 0x11C;
    constexpr std::uint32_t kError = board::kUart + 0x124;
    if (take_event(kError)) {
        const std::uint32_t source = reg(board::kUart + 0x480);
        reg(board::kUart + 0x480) = source;  // write 1 to clear
        board::g_lost = true;
    }
    while (take_event(kReceived)) {
        const auto character = static_cast<std::uint8_t>(reg(board::kUart + 0x518));
        const bool damaged = board::g_lost;
        board::g_lost = false;
        board::g_events->on_character(character, damaged);
    }
    if (take_event(kSent)) board::g_events->on_sent();
}

void one_shot_interrupt() {
    if (take_event(board::kOneShot + 0x140)) board::g_events->on_timer();  // else stopped meanwhile
}

/// TIMER2, free for the image.
[[gnu::weak]] void timer2_interrupt() {
    stop();
}

[[gnu::section(".board_vectors"), gnu::used]] constinit const auto board_vectors =
    board_vectors_of<32>({{board::kUartInterrupt, uart_interrupt},
                          {board::kOneShotInterrupt, one_shot_interrupt},
                          {board::kTimer2Interrupt, timer2_interrupt}});

}  // extern "C"
