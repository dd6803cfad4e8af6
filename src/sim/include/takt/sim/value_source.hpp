// What simulated devices hold that nobody has written, when it is told from outside.
#pragma once

#include <cstdint>

#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/function.hpp"

namespace takt::sim {

/// The content of every item of every device as a function of time, in the place of the patterns: tests that
/// must see from a value which item it was, and when, give their own. Items that were written keep what was
/// written.
class ValueSource {
public:
    /// @param address  of a register, or of a bit: then only the lowest bit of the answer counts
    [[nodiscard]] virtual std::uint16_t item(UnitId unit, wire::Area area, std::uint16_t address,
                                             Instant t) const = 0;

protected:
    ~ValueSource() = default;
};

}  // namespace takt::sim
