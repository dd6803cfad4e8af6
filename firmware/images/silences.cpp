// For tests on `microbit`: plays the characters of the file "script" at exact times into the slave. QEMU's
// UART has no time between characters, but its timers are exact under -icount. The responses leave by the
// UART.
//
// script: words of 32 bits. Bit rate; strictness, 1 or 0; framing, 0 RTU, 1 ASCII; then for each character
// the time in microseconds from the end of the last one to its own, and its value.
#include <algorithm>
#include <array>
#include <optional>

#include "takt/firmware/cortex_m.hpp"
#include "takt/firmware/semihosting.hpp"
#include "takt/firmware/serial_device.hpp"
#include "takt/firmware/slave_frame.hpp"
#include "takt/serve/diagnostics.hpp"

namespace {

namespace firmware = takt::firmware;
namespace serve = takt::serve;
namespace semihosting = takt::firmware::semihosting;
using takt::firmware::reg;

constexpr std::uint32_t kTimer = 0x4000A000;  // TIMER2
constexpr unsigned kTimerInterrupt = 10;
constexpr std::uint32_t kLongestResponse = 2'000'000;  // microseconds

struct Step {
    std::uint32_t gap;
    std::uint32_t character;
};
struct Script {
    std::uint32_t baud;
    std::uint32_t strict;
    std::uint32_t ascii;
    std::array<Step, 1000> steps;
};
Script g_script;
std::size_t g_steps;

std::optional<firmware::SerialDevice> g_device;
volatile std::size_t g_next;       // step
volatile std::uint32_t g_last_at;  // when the last character ended
firmware::BankStorage<16, 16, 16, 64> g_banks;

/// Measures how long after its last character a request is handled; the response begins then.
class Hooks final : public serve::UnitHooks {
public:
    std::optional<takt::wire::ExceptionCode> before(const serve::Context&, const serve::Access&) override {
        return std::nullopt;
    }
    void written(const serve::Context&, const serve::Access&) override {}
    void handled(const serve::Context&, const takt::wire::RequestView&, const serve::Answer&) override {
        const std::uint32_t delay = firmware::board::clock() - g_last_at;
        soonest = std::min(soonest, delay);
        latest = std::max(latest, delay);
    }

    std::uint32_t soonest = ~0U;
    std::uint32_t latest = 0;
};

void play_next() {
    reg(kTimer + 0x004) = 1;
    reg(kTimer + 0x00C) = 1;
    reg(kTimer + 0x540) = g_next < g_steps ? g_script.steps[g_next].gap : kLongestResponse;
    reg(kTimer + 0x000) = 1;
}

void start_script() {
    reg(kTimer + 0x508) = 3;          // 32 bits
    reg(kTimer + 0x510) = 4;          // 1 MHz
    reg(kTimer + 0x200) = 1U << 8U;   // stops at CC[0]
    reg(kTimer + 0x304) = 1U << 16U;  // interrupt at CC[0]
    firmware::enable_interrupt(kTimerInterrupt);
    play_next();
}

}  // namespace

extern "C" void timer2_interrupt() {
    reg(kTimer + 0x140) = 0;
    if (g_next < g_steps) {
        // The next time counts from now; what the device does with the character is no part of it.
        const auto character = static_cast<std::uint8_t>(g_script.steps[g_next].character);
        g_next = g_next + 1;
        play_next();
        g_last_at = firmware::board::clock();
        g_device->on_character(character, false);
        return;
    }
    g_next = g_steps + 1;
}

int main() {
    const std::size_t size =
        semihosting::read_file("script", 6, {reinterpret_cast<std::uint8_t*>(&g_script), sizeof g_script});
    g_steps = (size - offsetof(Script, steps)) / sizeof(Step);
    for (std::size_t i = 0; i < g_banks.holding_registers.size(); ++i)
        g_banks.holding_registers[i] = static_cast<std::uint16_t>(i);
    static Hooks hooks;
    static serve::Diagnostics diagnostics;
    static serve::Extension* const extensions[]{&diagnostics};
    static std::array units{serve::Unit{takt::UnitId{1}, g_banks.banks(), &hooks, extensions}};
    static serve::Server server(units);
    g_device.emplace(
        firmware::SerialDeviceConfig{
            .framing = g_script.ascii != 0 ? takt::wire::Framing::ascii : takt::wire::Framing::rtu,
            .format = {.baud = g_script.baud, .parity = takt::wire::Parity::none},
            .strict = g_script.strict != 0},
        server);
    if (!g_device->start()) return 1;
    start_script();
    while (g_next <= g_steps) {
        if (g_device->work()) continue;
        const firmware::InterruptLock lock;
        if (!g_device->has_work() && g_next <= g_steps) firmware::board::sleep();
    }
    semihosting::write("soonest", hooks.soonest);
    semihosting::write("latest", hooks.latest);
    semihosting::exit();
}
