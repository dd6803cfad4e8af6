// Requests to the debugger or emulator (Arm Semihosting for AArch32 and AArch64, release 2.0). For images of
// tests: on a board without a debugger they stop the program.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace takt::firmware::semihosting {

inline std::int32_t call(std::uint32_t operation, const void* parameters) {
    register std::uint32_t r0 asm("r0") = operation;
    register const void* r1 asm("r1") = parameters;
    asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return static_cast<std::int32_t>(r0);
}

/// @param text  ends with a zero
inline void write(const char* text) {
    call(0x04, text);
}

inline void write(const char* name, std::uint32_t value) {
    std::array<char, 12> digits{};
    char* first = &digits[digits.size() - 2];
    do *--first = static_cast<char>('0' + value % 10);
    while ((value /= 10) != 0);
    write(name);
    write(" ");
    write(first);
    write("\n");
}

/// Reads the beginning of a file in the folder of the emulator.
/// @returns bytes read; 0: there is no such file
inline std::size_t read_file(const char* name, std::size_t length, std::span<std::uint8_t> into) {
    constexpr std::uint32_t kReadBinary = 1;
    const std::uintptr_t open[]{reinterpret_cast<std::uintptr_t>(name), kReadBinary, length};
    const std::int32_t handle = call(0x01, open);
    if (handle < 0) return 0;
    const std::uintptr_t read[]{static_cast<std::uintptr_t>(handle),
                                reinterpret_cast<std::uintptr_t>(into.data()), into.size()};
    return into.size() - static_cast<std::size_t>(call(0x06, read));
}

/// Ends the emulator with exit code 0.
[[noreturn]] inline void exit() {
    constexpr std::uintptr_t kApplicationExit = 0x20026;
    call(0x18, reinterpret_cast<const void*>(kApplicationExit));
    for (;;) {}
}

}  // namespace takt::firmware::semihosting
