// Interrupts and registers of a Cortex-M.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

/// Stops the device where a debugger can see it (startup.cpp).
extern "C" [[noreturn]] void stop();

namespace takt::firmware {

/// A register of a peripheral, by its address in the reference manual.
inline volatile std::uint32_t& reg(std::uint32_t address) {
    return *reinterpret_cast<volatile std::uint32_t*>(address);
}

/// Clears an event of a peripheral whose register a write of 0 clears.
/// @returns whether it had happened
inline bool take_event(std::uint32_t address) {
    const bool happened = reg(address) != 0;
    if (happened) reg(address) = 0;
    return happened;
}

inline void wait_for_interrupt() {
    asm volatile("dsb\n wfi" ::: "memory");
}

/// Enables the interrupt of that number in the NVIC (ARMv6-M and ARMv7-M).
inline void enable_interrupt(unsigned number) {
    reg(0xE000E100U + 4 * (number / 32)) = 1U << (number % 32);
}

/// The function of an interrupt, by its number in the NVIC.
struct InterruptHandler {
    unsigned interrupt;
    void (*function)();
};

/// The interrupts of a board's peripherals, for the section .board_vectors. Those without a function stop it.
template <std::size_t Count>
constexpr std::array<void (*)(), Count> board_vectors_of(std::initializer_list<InterruptHandler> handlers) {
    std::array<void (*)(), Count> vectors{};
    vectors.fill(stop);
    for (const InterruptHandler& handler : handlers) vectors[handler.interrupt] = handler.function;
    return vectors;
}

/// Masks interrupts while it lives; inside interrupts and other locks, too. WFI ends with an interrupt that
/// is masked, which is handled afterwards: so none is missed between the check for work and the sleep.
class InterruptLock {
public:
    InterruptLock() { asm volatile("mrs %0, primask\n cpsid i" : "=r"(before_)::"memory"); }
    ~InterruptLock() { asm volatile("msr primask, %0" ::"r"(before_) : "memory"); }
    InterruptLock(const InterruptLock&) = delete;
    InterruptLock& operator=(const InterruptLock&) = delete;

private:
    std::uint32_t before_;
};

}  // namespace takt::firmware
