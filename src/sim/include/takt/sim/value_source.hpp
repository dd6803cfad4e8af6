// Contents of simulated devices from outside.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

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

/// The values of a plant as functions of time, by the name of the variable, instead of their patterns.
class PlantModel {
public:
    /// @returns the value as the variable shows it, scaled; a bool is 0 or 1. Nothing: the variable keeps its
    ///          pattern
    [[nodiscard]] virtual std::optional<double> value(std::string_view variable, Instant t) const = 0;
    /// A master wrote the variable: it keeps this value, scaled, and others may follow.
    virtual void on_written(std::string_view variable, double value, Instant t) = 0;

protected:
    ~PlantModel() = default;
};

}  // namespace takt::sim
