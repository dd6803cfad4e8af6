// Converts registers to values and back (docs/specification.md, section 2).
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "takt/base/data_type.hpp"
#include "takt/base/inplace_vector.hpp"
#include "takt/base/result.hpp"
#include "takt/value/value.hpp"

namespace takt::value {

/// The encoding of a value in the registers of a device.
struct Layout {
    DataType type = DataType::int16;
    ByteOrder order;
    std::uint16_t registers = 1;      ///< of a string, 1..125; given by the type otherwise
    std::optional<std::uint8_t> bit;  ///< of a bool in a register: 0..15; without: the register is 0 or not
    double scale = 1;                 ///< value = raw * scale + offset; not 0, finite
    double offset = 0;

    [[nodiscard]] bool scaled() const { return scale != 1 || offset != 0; }
    [[nodiscard]] int register_count() const { return takt::register_count(type, registers); }
};

/// The registers of one value as written.
struct Encoded {
    InplaceVector<std::uint16_t, 125> registers;
    bool rounded = false;  ///< the encoded value differs from the requested one
};

/// Decodes `registers`, in the order of their addresses.
///
/// Strings: the value ends at the first NUL byte. A register holds two bytes, the first one in the high byte
/// if high_byte_first. The order of registers does not apply. Scaling: scale and offset of a few decimal
/// digits are applied exactly; raw 12 with scale 0.1 is the double 1.2. Bits of coil areas do not use this
/// codec.
/// @returns too_short (registers there, needed)
Result<Value> decode(const Layout& layout, std::span<const std::uint16_t> registers);

/// The exact inverse of decode(). Integers are rounded to nearest, halves away from zero; `rounded` reports
/// it. If several raw values decode to the value, the one nearest to (value - offset) / scale is taken. Every
/// number type accepts every numeric alternative; a bool accepts 0 and 1. A bool without `bit` encodes to 0
/// or 1. With `bit` only that bit is set, and the caller merges it. A text is cut at its first NUL byte.
/// @returns overflow (beyond the type; a string longer than its registers; a finite double beyond a float);
///          out_of_range (NaN or infinity for an integer); unsupported (text for a number or the reverse)
Result<Encoded> encode(const Layout& layout, const Value& value);

/// The bits of each of its registers, as on the wire, that a value fills: all, or that of a bool with `bit`,
/// which counts the bits after the byte order was applied. The caller of encode() keeps the others.
std::uint16_t register_mask(const Layout& layout);

/// Converts `value` to the alternative that a variable or local of that type holds. Only exact conversions.
/// @returns overflow, out_of_range, unsupported as encode(); out_of_range for a fraction to an integer
Result<Value> convert(DataType type, bool scaled, const Value& value);

}  // namespace takt::value
