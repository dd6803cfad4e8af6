// Arm MPS2 with the image AN385 (Cortex-M3) or AN386 (Cortex-M4). Registers: Arm Cortex-M System Design Kit
// TRM, application notes AN385 and AN386. These boards have no flash.
#include <array>

#include "takt/firmware/board.hpp"
#include "takt/firmware/cortex_m.hpp"

namespace takt::firmware::board {
namespace {

constexpr unsigned kPorts = 2;
constexpr std::array<std::uint32_t, kPorts> kUarts{0x40004000, 0x40005000};
constexpr std::uint32_t kOneShot = 0x40000000;  // timer 0, of port 0
constexpr std::uint32_t kDual = 0x40002000;     // dual timer, of port 1
constexpr std::uint32_t kClock = 0x40001000;    // timer 1
constexpr std::uint32_t kPort = 0x40010000;     // GPIO 0
constexpr std::array<std::uint32_t, kPorts> kDriverPins{3, 4};

constexpr std::uint32_t kHertz = 25'000'000;
constexpr std::uint32_t kTicks = kHertz / 1'000'000;  // in a microsecond
constexpr std::array<unsigned, kPorts> kReceiveInterrupts{0, 2};
constexpr std::array<unsigned, kPorts> kSendInterrupts{1, 3};
constexpr std::array<unsigned, kPorts> kOneShotInterrupts{8, 10};
constexpr unsigned kEthernetInterrupt = 13;

// Memory of the code in place of the flash that these boards do not have. A loader may fill it.
constexpr unsigned kFirstTablePage = 2;
constexpr unsigned kPageCount = 4;
constexpr std::uintptr_t kTablePages = 0x00200000;
constexpr std::size_t kTablePageWords = 0x1000;

std::array<BoardEvents*, kPorts> g_events;
std::uint32_t g_last_ticks;
std::uint32_t g_ticks;         // above whole microseconds
std::uint32_t g_microseconds;  // up to g_last_ticks

}  // namespace

// The counter of ticks wraps around after 172 s: it is read at least that often by any traffic, and otherwise
// its differences have no meaning.
std::uint32_t clock() {
    const InterruptLock lock;                       // interrupts read it, too
    const std::uint32_t now = ~reg(kClock + 0x04);  // it counts down
    const std::uint32_t passed = g_ticks + (now - g_last_ticks);
    g_last_ticks = now;
    g_microseconds += passed / kTicks;
    g_ticks = passed % kTicks;
    return g_microseconds;
}

bool open(const wire::CharacterFormat& format, BoardEvents& events, unsigned port) {
    constexpr std::uint32_t kLeastDivider = 16;
    const bool possible = port < kPorts && format.data_bits == 8 && format.stop_bits == 1 &&
                          format.parity == wire::Parity::none && kHertz / format.baud >= kLeastDivider;
    if (!possible) return false;
    g_events[port] = &events;
    if (reg(kClock) == 0) {
        reg(kClock + 0x08) = ~0U;
        reg(kClock + 0x04) = ~0U;
        reg(kClock) = 1;
    }
    reg(kPort + 0x10) = 1U << kDriverPins[port];  // output
    reg(kUarts[port] + 0x10) = kHertz / format.baud;
    reg(kUarts[port] + 0x08) = 0xF;  // transmitter, receiver and their interrupts
    enable_interrupt(kReceiveInterrupts[port]);
    enable_interrupt(kSendInterrupts[port]);
    enable_interrupt(kOneShotInterrupts[port]);
    return true;
}

void send(std::uint8_t character, unsigned port) {
    reg(kUarts[port]) = character;
}

void start_timer(std::uint32_t microseconds, unsigned port) {
    stop_timer(port);
    const std::uint32_t ticks = microseconds * kTicks;
    if (port == 1) {
        constexpr std::uint32_t kOnce = 1, k32Bits = 2, kInterrupt = 0x20, kEnable = 0x80;
        reg(kDual) = ticks;
        reg(kDual + 0x08) = kOnce | k32Bits | kInterrupt | kEnable;
        return;
    }
    reg(kOneShot + 0x08) = 0;  // no second time
    reg(kOneShot + 0x04) = ticks;
    reg(kOneShot) = 1 | 1U << 3U;
}

void stop_timer(unsigned port) {
    const std::uint32_t timer = port == 1 ? kDual : kOneShot;
    reg(timer + (port == 1 ? 0x08 : 0)) = 0;
    reg(timer + 0x0C) = 1;  // the interrupt
}

void drive_line(bool on, unsigned port) {
    const std::uint32_t pin = 1U << kDriverPins[port];
    reg(kPort + 0x400 + 4 * pin) = on ? pin : 0;  // the address has the mask
}

std::span<const std::uint32_t> flash_page(unsigned page) {
    if (page < kFirstTablePage || page >= kPageCount) return {};
    const auto* first = reinterpret_cast<const std::uint32_t*>(kTablePages);
    return {first + (page - kFirstTablePage) * kTablePageWords, kTablePageWords};
}

void erase_page(unsigned page) {
    for (std::size_t i = 0; i < flash_page(page).size(); ++i) write_word(page, i, ~0U);
}

void write_word(unsigned page, std::size_t index, std::uint32_t word) {
    reg(kTablePages + ((page - kFirstTablePage) * kTablePageWords + index) * sizeof word) = word;
}

void sleep() {
    wait_for_interrupt();
}

}  // namespace takt::firmware::board

namespace takt::firmware {
namespace {

void receive_interrupt(unsigned port) {
    constexpr std::uint32_t kFull = 1U << 1U;
    constexpr std::uint32_t kOverrun = 1U << 3U;
    const std::uint32_t uart = board::kUarts[port];
    reg(uart + 0x0C) = 1U << 1U;
    const std::uint32_t state = reg(uart + 0x04);
    if ((state & kFull) == 0) return;
    const auto character = static_cast<std::uint8_t>(reg(uart));
    reg(uart + 0x04) = kOverrun;  // write 1 to clear
    board::g_events[port]->on_character(character, (state & kOverrun) != 0);
}

// The interrupt of this UART says that its buffer is free; its shift register holds the last character.
void send_interrupt(unsigned port) {
    reg(board::kUarts[port] + 0x0C) = 1U << 0U;
    board::g_events[port]->on_sent();
}

void one_shot_interrupt(unsigned port) {
    if (reg(port == 1 ? board::kDual + 0x08 : board::kOneShot) == 0) return;  // stopped meanwhile
    board::stop_timer(port);
    board::g_events[port]->on_timer();
}

}  // namespace
}  // namespace takt::firmware

extern "C" {

using namespace takt::firmware;

void receive_0_interrupt() {
    receive_interrupt(0);
}
void receive_1_interrupt() {
    receive_interrupt(1);
}
void send_0_interrupt() {
    send_interrupt(0);
}
void send_1_interrupt() {
    send_interrupt(1);
}
void one_shot_0_interrupt() {
    one_shot_interrupt(0);
}
void one_shot_1_interrupt() {
    one_shot_interrupt(1);
}
/// The Ethernet controller, free for the image.
[[gnu::weak]] void ethernet_interrupt() {
    stop();
}

[[gnu::section(".board_vectors"), gnu::used]] constinit const auto board_vectors =
    board_vectors_of<32>({{board::kReceiveInterrupts[0], receive_0_interrupt},
                          {board::kReceiveInterrupts[1], receive_1_interrupt},
                          {board::kSendInterrupts[0], send_0_interrupt},
                          {board::kSendInterrupts[1], send_1_interrupt},
                          {board::kOneShotInterrupts[0], one_shot_0_interrupt},
                          {board::kOneShotInterrupts[1], one_shot_1_interrupt},
                          {board::kEthernetInterrupt, ethernet_interrupt}});

}  // extern "C"
