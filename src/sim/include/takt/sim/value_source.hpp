// Contents of simulated devices from outside.
#pragma once

#include <cstdint>

#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/function.hpp"

namespace takt::sim {

/// The content of every item of every device as a function of time, instead of the patterns. Tests use it to
/// recognise from a value the item and the time of its reading. Written items keep their written value.
class ValueSource {
public:
    /// @param address  register, or bit: then only the lowest bit of the result counts
    [[nodiscard]] virtual std::uint16_t item(UnitId unit, wire::Area area, std::uint16_t address,
                                             Instant t) const = 0;

protected:
    ~ValueSource() = default;
};

}  // namespace takt::sim
