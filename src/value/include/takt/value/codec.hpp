// Registers to values and back (specification, section 2).
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "takt/base/data_type.hpp"
#include "takt/base/inplace_vector.hpp"
#include "takt/base/result.hpp"
#include "takt/value/value.hpp"

namespace takt::value {

/// How a value lies in the registers of a device.
struct Layout {
    DataType type = DataType::int16;
    ByteOrder order;
    std::uint16_t registers = 1;      ///< of a string, 1..125; the other types know their own number
    std::optional<std::uint8_t> bit;  ///< of a bool in a register: 0..15; without: the register is 0 or not
    double scale = 1;                 ///< value = raw * scale + offset; not 0, finite
    double offset = 0;

    [[nodiscard]] bool scaled() const { return scale != 1 || offset != 0; }
    [[nodiscard]] int register_count() const { return takt::register_count(type, registers); }
};

/// The registers of one value as written.
struct Encoded {
    InplaceVector<std::uint16_t, 125> registers;
    bool rounded = false;  ///< what is read back differs from what was to be written
};

/// The value of `registers`, in the order of their addresses.
///
/// A string ends at its first NUL byte; bytes lie two a register, the first in the high byte when
/// high_byte_first; the order of registers does not apply to strings. Scale and offset of a few decimal
/// digits are applied exactly: raw 12 with scale 0.1 is the double 1.2. Bits of coil areas are no matter of
/// this codec.
/// @returns too_short (registers there, needed)
Result<Value> decode(const Layout& layout, std::span<const std::uint16_t> registers);

/// The exact inverse of decode(). Integers are rounded to nearest, halves away from zero, and the rounding is
/// told. Where several raw values give the same value the nearest to the straight inverse is taken. Numbers
/// of any alternative are accepted for any number type; 0 and 1 for a bool. A bool without `bit` gives 0 or
/// 1; with `bit` only that bit is set (the caller merges it).
/// @returns overflow (of the type; also a string longer than its registers, or a finite double beyond a
/// float);
///          out_of_range for NaN or infinity to an integer; unsupported where text meets a number
Result<Encoded> encode(const Layout& layout, const Value& value);

/// `value` as the alternative a variable or local of that type holds; only exact conversions.
/// @returns overflow, out_of_range, unsupported as encode(); out_of_range for a fraction to an integer
Result<Value> convert(DataType type, bool scaled, const Value& value);

}  // namespace takt::value
