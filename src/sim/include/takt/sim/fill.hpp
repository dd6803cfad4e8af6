// The first content of registers and bits.
#pragma once

#include <cstdint>

#include "takt/sim/random.hpp"

namespace takt::sim {

/// Zeros; a ramp (register a holds a, bit a holds a & 1); or noise from a fixed seed.
enum class Fill : std::uint8_t { zero, ramp, random };

/// The items one after the other.
class Content {
public:
    explicit Content(Fill fill) : fill_(fill) {}

    /// Of a bit the lowest one counts.
    [[nodiscard]] std::uint16_t item(unsigned address) {
        if (fill_ == Fill::random) return static_cast<std::uint16_t>(noise_.next());
        return static_cast<std::uint16_t>(fill_ == Fill::ramp ? address : 0U);
    }

private:
    Fill fill_;
    Random noise_{1};
};

}  // namespace takt::sim
