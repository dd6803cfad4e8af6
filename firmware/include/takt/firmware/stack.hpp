// The stack of an image, painted at start (startup.cpp).
#pragma once

#include <cstddef>
#include <cstdint>

extern "C" {
extern std::uint32_t stack_bottom;  ///< sections.ld
extern std::uint32_t stack_top;
}

namespace takt::firmware {

inline constexpr std::uint32_t kStackPaint = 0xA5A5A5A5;

/// The most bytes of stack that were in use since the start, interrupts included.
[[nodiscard]] inline std::size_t stack_used() {
    const std::uint32_t* lowest = &stack_bottom;
    while (lowest != &stack_top && *lowest == kStackPaint) ++lowest;
    return static_cast<std::size_t>(&stack_top - lowest) * sizeof(std::uint32_t);
}

}  // namespace takt::firmware
