// Registers to values as the judge reads them (docs/specification.md, section 2).
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "takt/base/time.hpp"
#include "takt/model/project.hpp"
#include "takt/value/value.hpp"

namespace takt::judge {

/// The value of a variable in these items. Scaled values in floating point.
[[nodiscard]] value::Value value_of(const model::Variable& variable, std::span<const std::uint16_t> items);

/// Whether these items hold the given value. Scaled and single-precision numbers are compared up to rounding.
/// @param rounding  the value was requested and may have been rounded to what the device can hold
[[nodiscard]] bool holds(const model::Variable& variable, std::span<const std::uint16_t> items,
                         const value::Value& shown, bool rounding);

/// The same value, bit for bit up to NaN.
[[nodiscard]] bool equal(const value::Value& a, const value::Value& b);

[[nodiscard]] std::string text(const value::Value& value);
[[nodiscard]] std::string text(std::span<const std::uint16_t> items);

/// "1.250 ms"
[[nodiscard]] std::string milliseconds(Duration time);

}  // namespace takt::judge
