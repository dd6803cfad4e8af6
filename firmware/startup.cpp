// From reset to main() on a Cortex-M: initial values and zeroes, and the stack painted (stack.hpp). There are
// no constructors to run (sections.ld). The vector table has the entries of every core; those of a board's
// peripherals follow (board_vectors).
#include <cstdint>

#include "takt/firmware/stack.hpp"

using takt::firmware::kStackPaint;

extern "C" {

extern std::uint32_t stack_top;
extern std::uint32_t data_source;
extern std::uint32_t data_begin;
extern std::uint32_t data_end;
extern std::uint32_t bss_begin;
extern std::uint32_t bss_end;
extern std::uint32_t stack_bottom;

int main();

[[noreturn]] void stop() {
    for (;;) asm volatile("bkpt #0");
}

/// A broken expectation stops the device where a debugger can see it.
[[noreturn]] void abort() {
    stop();
}

/// main() does not return: no destructor runs.
int atexit(void (*)()) {
    return 0;
}

[[noreturn]] void reset() {
    const std::uint32_t* from = &data_source;
    for (std::uint32_t* to = &data_begin; to != &data_end;) *to++ = *from++;
    for (std::uint32_t* to = &bss_begin; to != &bss_end;) *to++ = 0;
    std::uint32_t* const here = static_cast<std::uint32_t*>(__builtin_frame_address(0));
    for (std::uint32_t* to = &stack_bottom; to < here - 16; ++to) *to = kStackPaint;
    main();
    stop();
}

[[gnu::section(".vectors"), gnu::used]] const std::uintptr_t vectors[16]{
    reinterpret_cast<std::uintptr_t>(&stack_top), reinterpret_cast<std::uintptr_t>(&reset),
    reinterpret_cast<std::uintptr_t>(&stop),  // NMI
    reinterpret_cast<std::uintptr_t>(&stop),  // hard fault
};

}  // extern "C"
