// From reset to main() on a Cortex-M: initial values, zeroes, constructors. The vector table has the entries
// every core has; a board adds those of its peripherals.
#include <cstdint>

extern "C" {

extern std::uint32_t stack_top;
extern std::uint32_t data_source;
extern std::uint32_t data_begin;
extern std::uint32_t data_end;
extern std::uint32_t bss_begin;
extern std::uint32_t bss_end;
extern void (*init_array_begin[])();
extern void (*init_array_end[])();

int main();

[[noreturn]] void stop() {
    for (;;) asm volatile("bkpt #0");
}

/// A broken expectation stops the device where a debugger can see it.
[[noreturn]] void abort() {
    stop();
}

[[noreturn]] void reset() {
    const std::uint32_t* from = &data_source;
    for (std::uint32_t* to = &data_begin; to != &data_end;) *to++ = *from++;
    for (std::uint32_t* to = &bss_begin; to != &bss_end;) *to++ = 0;
    for (auto* constructor = init_array_begin; constructor != init_array_end; ++constructor) (*constructor)();
    main();
    stop();
}

[[gnu::section(".vectors"), gnu::used]] const std::uintptr_t vectors[16]{
    reinterpret_cast<std::uintptr_t>(&stack_top), reinterpret_cast<std::uintptr_t>(&reset),
    reinterpret_cast<std::uintptr_t>(&stop),  // NMI
    reinterpret_cast<std::uintptr_t>(&stop),  // hard fault
};

}  // extern "C"
