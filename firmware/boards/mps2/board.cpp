// Arm MPS2 with the image AN385 (Cortex-M3) or AN386 (Cortex-M4). Registers: Arm Cortex-M System Design Kit
// TRM, application notes AN385 and AN386. These boards have no flash.
#include "takt/firmware/board.hpp"

#include "takt/firmware/cortex_m.hpp"

namespace takt::firmware::board {
namespace {

constexpr std::uint32_t kUart = 0x40004000;     // UART 0
constexpr std::uint32_t kOneShot = 0x40000000;  // timer 0
constexpr std::uint32_t kClock = 0x40001000;    // timer 1
constexpr std::uint32_t kPort = 0x40010000;     // GPIO 0
constexpr std::uint32_t kDriverPin = 3;

constexpr std::uint32_t kHertz = 25'000'000;
constexpr std::uint32_t kTicks = kHertz / 1'000'000;  // in a microsecond
constexpr unsigned kReceiveInterrupt = 0;
constexpr unsigned kSendInterrupt = 1;
constexpr unsigned kOneShotInterrupt = 8;

BoardEvents* g_events;
std::uint32_t g_last_ticks;
std::uint32_t g_ticks;         // above whole microseconds
std::uint32_t g_microseconds;  // up to g_last_ticks

}  // namespace

// The counter of ticks wraps around after 172 s: it is read at least that often by any traffic, and otherwise
// its differences have no meaning.
std::uint32_t clock() {
    const std::uint32_t now = ~reg(kClock + 0x04);  // it counts down
    const std::uint32_t passed = g_ticks + (now - g_last_ticks);
    g_last_ticks = now;
    g_microseconds += passed / kTicks;
    g_ticks = passed % kTicks;
    return g_microseconds;
}

bool open(const wire::CharacterFormat& format, BoardEvents& events) {
    constexpr std::uint32_t kLeastDivider = 16;
    const bool possible = format.data_bits == 8 && format.stop_bits == 1 &&
                          format.parity == wire::Parity::none && kHertz / format.baud >= kLeastDivider;
    if (!possible) return false;
    g_events = &events;
    reg(kClock + 0x08) = ~0U;
    reg(kClock + 0x04) = ~0U;
    reg(kClock) = 1;
    reg(kPort + 0x10) = 1U << kDriverPin;  // output
    reg(kUart + 0x10) = kHertz / format.baud;
    reg(kUart + 0x08) = 0xF;  // transmitter, receiver and their interrupts
    enable_interrupt(kReceiveInterrupt);
    enable_interrupt(kSendInterrupt);
    enable_interrupt(kOneShotInterrupt);
    return true;
}

void send(std::uint8_t character) {
    reg(kUart) = character;
}

void start_timer(std::uint32_t microseconds) {
    stop_timer();
    reg(kOneShot + 0x08) = 0;  // no second time
    reg(kOneShot + 0x04) = microseconds * kTicks;
    reg(kOneShot) = 1 | 1U << 3U;
}

void stop_timer() {
    reg(kOneShot) = 0;
    reg(kOneShot + 0x0C) = 1;
}

void drive_line(bool on) {
    reg(kPort + 0x04) = on ? 1U << kDriverPin : 0;
}

std::span<const std::uint32_t> flash_page(unsigned) {
    return {};
}

void erase_page(unsigned) {}

void write_word(unsigned, std::size_t, std::uint32_t) {}

void sleep() {
    wait_for_interrupt();
}

}  // namespace takt::firmware::board

extern "C" {

using namespace takt::firmware;

void receive_interrupt() {
    constexpr std::uint32_t kFull = 1U << 1U;
    constexpr std::uint32_t kOverrun = 1U << 3U;
    reg(board::kUart + 0x0C) = 1U << 1U;
    const std::uint32_t state = reg(board::kUart + 0x04);
    if ((state & kFull) == 0) return;
    const auto character = static_cast<std::uint8_t>(reg(board::kUart));
    reg(board::kUart + 0x04) = kOverrun;  // write 1 to clear
    board::g_events->on_character(character, (state & kOverrun) != 0);
}

// The interrupt of this UART says that its buffer is free; its shift register holds the last character.
void send_interrupt() {
    reg(board::kUart + 0x0C) = 1U << 0U;
    board::g_events->on_sent();
}

void one_shot_interrupt() {
    if (reg(board::kOneShot) == 0) return;  // stopped meanwhile
    board::stop_timer();
    board::g_events->on_timer();
}

void stop();
/// The Ethernet controller, free for the image.
[[gnu::weak]] void ethernet_interrupt() {
    stop();
}

[[gnu::section(".board_vectors"), gnu::used]] void (*const board_vectors[32])() = {receive_interrupt,
                                                                                   send_interrupt,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   one_shot_interrupt,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   ethernet_interrupt,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop,
                                                                                   stop};

}  // extern "C"
