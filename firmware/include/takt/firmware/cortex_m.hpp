// Interrupts and registers of a Cortex-M.
#pragma once

#include <cstdint>

namespace takt::firmware {

/// A register of a peripheral, by its address in the reference manual.
inline volatile std::uint32_t& reg(std::uint32_t address) {
    return *reinterpret_cast<volatile std::uint32_t*>(address);
}

inline void wait_for_interrupt() {
    asm volatile("dsb\n wfi" ::: "memory");
}

/// Enables the interrupt of that number in the NVIC (ARMv6-M and ARMv7-M).
inline void enable_interrupt(unsigned number) {
    reg(0xE000E100U + 4 * (number / 32)) = 1U << (number % 32);
}

/// Masks interrupts while it lives. WFI ends with an interrupt that is masked, which is handled afterwards:
/// so none is missed between the check for work and the sleep.
class InterruptLock {
public:
    InterruptLock() { asm volatile("cpsid i" ::: "memory"); }
    ~InterruptLock() { asm volatile("cpsie i" ::: "memory"); }
    InterruptLock(const InterruptLock&) = delete;
    InterruptLock& operator=(const InterruptLock&) = delete;
};

}  // namespace takt::firmware
