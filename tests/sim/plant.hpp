// The values that simulated devices measure: each item has its own sequence, so that a value shows which
// item of which device it is, and when it was there.
#pragma once

#include "takt/sim/value_source.hpp"

namespace takt::simtest {

class Plant final : public sim::ValueSource {
public:
    /// @param step  all items change together so often
    Plant(std::uint64_t seed, Duration step) : seed_(seed), step_(step) {}

    [[nodiscard]] std::uint16_t item(UnitId unit, wire::Area area, std::uint16_t address,
                                     Instant t) const override {
        const auto moment = static_cast<std::uint64_t>(t.time_since_epoch() / step_);
        std::uint64_t x = seed_ ^ (moment << 28U) ^ (std::uint64_t{unit.value} << 18U) ^
                          (static_cast<std::uint64_t>(area) << 16U) ^ address;
        x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9;
        x = (x ^ (x >> 27U)) * 0x94D049BB133111EB;
        return static_cast<std::uint16_t>(x >> 40U);
    }

private:
    std::uint64_t seed_;
    Duration step_;
};

}  // namespace takt::simtest
