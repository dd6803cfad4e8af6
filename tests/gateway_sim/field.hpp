// The values that the simulated devices measure.
#pragma once

#include "takt/sim/value_source.hpp"

namespace takt::gatewaysim {

/// Registers by their use, in blocks of a hundred.
enum class RegisterUse : std::uint8_t {
    fast,      ///< changes with each step
    slow,      ///< changes every five seconds
    constant,  ///< never changes
    noise,     ///< changes with each step by a little
    written,   ///< keeps what was written
    text,      ///< two letters that change with each step; all further registers
};
inline constexpr std::uint16_t kRegistersOfAUse = 100;

class Field final : public sim::ValueSource {
public:
    Field(std::uint64_t seed, Duration step) : seed_(seed), step_(step) {}

    [[nodiscard]] std::uint16_t item(UnitId unit, wire::Area /*area*/, std::uint16_t address,
                                     Instant t) const override {
        switch (static_cast<RegisterUse>(address / kRegistersOfAUse)) {
            case RegisterUse::fast: return mixed(unit, address, t, step_);
            case RegisterUse::slow: return mixed(unit, address, t, std::chrono::seconds(5));
            case RegisterUse::constant: return 4711;
            case RegisterUse::noise: return 1000 + mixed(unit, address, t, step_) % 10;
            case RegisterUse::written: return 0;
            default: return letters(mixed(unit, address, t, step_));
        }
    }

private:
    [[nodiscard]] std::uint16_t mixed(UnitId unit, std::uint16_t address, Instant t, Duration step) const {
        const auto moment = static_cast<std::uint64_t>(t.time_since_epoch() / step);
        std::uint64_t x = seed_ ^ (moment << 28U) ^ (std::uint64_t{unit.value} << 18U) ^ address;
        x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9;
        x = (x ^ (x >> 27U)) * 0x94D049BB133111EB;
        return static_cast<std::uint16_t>(x >> 40U);
    }
    [[nodiscard]] static std::uint16_t letters(std::uint16_t x) {
        return static_cast<std::uint16_t>(('a' + x % 26) << 8U | ('a' + x / 26 % 26));
    }

    std::uint64_t seed_;
    Duration step_;
};

}  // namespace takt::gatewaysim
