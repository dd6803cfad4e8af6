// For tests on `microbit`: stores values in retained registers until a timer resets the processor, at random
// times, over and over. After each reset, all that was stored must be there. What RAM keeps over a reset is
// the judge's memory.
//
// File "script": two words of 32 bits, the seed and the number of resets.
#include <array>

#include "takt/firmware/board.hpp"
#include "takt/firmware/cortex_m.hpp"
#include "takt/firmware/retained_registers.hpp"
#include "takt/firmware/semihosting.hpp"

namespace {

namespace firmware = takt::firmware;
namespace semihosting = takt::firmware::semihosting;
using takt::firmware::reg;

constexpr std::uint32_t kTimer = 0x4000A000;  // TIMER2
constexpr unsigned kTimerInterrupt = 10;
constexpr std::size_t kRegisters = 24;
constexpr std::uint32_t kLatest =
    4000;  // microseconds; a record takes some 100, an erasure and a full record 300
constexpr std::uint32_t kMagic = 0x54414B54;

using Values = std::array<std::uint16_t, kRegisters>;

struct Kept {
    std::uint32_t magic;
    std::uint32_t random;
    std::uint32_t resets;  // that are left
    std::uint32_t stores;
    std::uint32_t cut;  // resets inside of store()
    Values promised;
    bool open;  // inside of store(): the values are these or those before
    Values tried;
};
[[gnu::section(".kept")]] Kept g_kept;

std::uint32_t next_random() {  // xorshift32
    g_kept.random ^= g_kept.random << 13U;
    g_kept.random ^= g_kept.random >> 17U;
    g_kept.random ^= g_kept.random << 5U;
    return g_kept.random;
}

void reset_after(std::uint32_t microseconds) {
    reg(kTimer + 0x508) = 3;
    reg(kTimer + 0x510) = 4;
    reg(kTimer + 0x304) = 1U << 16U;
    reg(kTimer + 0x540) = microseconds;
    firmware::enable_interrupt(kTimerInterrupt);
    reg(kTimer) = 1;
}

void start_over() {
    std::array<std::uint32_t, 2> script{};
    semihosting::read_file("script", 6, {reinterpret_cast<std::uint8_t*>(script.data()), sizeof script});
    firmware::board::erase_page(0);
    firmware::board::erase_page(1);
    g_kept = {.magic = kMagic, .random = script[0] | 1U, .resets = script[1]};
}

void check(const Values& values) {
    if (values == g_kept.promised || (g_kept.open && values == g_kept.tried)) {
        g_kept.promised = values;
        if (g_kept.open) ++g_kept.cut;
        g_kept.open = false;
        return;
    }
    semihosting::write("lost_after", g_kept.stores);
    semihosting::exit();
}

}  // namespace

extern "C" void timer2_interrupt() {
    reg(0xE000ED0C) = 0x05FA0004;  // AIRCR: SYSRESETREQ
    for (;;) {}
}

int main() {
    if (g_kept.magic != kMagic) start_over();
    Values values{};
    firmware::RetainedRegisters retained(values);
    retained.restore();
    check(values);
    if (g_kept.resets == 0) {
        semihosting::write("stores", g_kept.stores);
        semihosting::write("cut", g_kept.cut);
        semihosting::exit();
    }
    --g_kept.resets;
    reset_after(1 + next_random() % kLatest);
    for (;;) {
        const std::size_t first = next_random() % kRegisters;
        const std::size_t count = 1 + next_random() % (kRegisters - first);
        for (std::size_t i = 0; i < count; ++i) values[first + i] = static_cast<std::uint16_t>(next_random());
        g_kept.tried = values;
        g_kept.open = true;
        retained.store(first, count);
        g_kept.promised = values;
        g_kept.open = false;
        ++g_kept.stores;
    }
}
