// The four areas of a unit, in storage that the caller provides.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "takt/base/engine.hpp"
#include "takt/wire/function.hpp"

namespace takt::serve {

/// Addresses first..last, inclusive.
struct AddressRange {
    std::uint16_t first = 0;
    std::uint16_t last = 0;
    friend constexpr bool operator==(const AddressRange&, const AddressRange&) = default;
};

/// Ascending and disjoint; ranges may adjoin. Must live as long as the bank.
using AddressRanges = std::span<const AddressRange>;

/// Bits that share the storage of registers of the same unit, as 0x and 4x in some devices. The first 16 bits
/// of the bank are those of register `first`, least significant bit first.
struct BitOverlay {
    wire::Area area = wire::Area::holding_register;  ///< input_register or holding_register
    std::uint16_t first = 0;
};

/// The allowed values of registers: `least` to `greatest`.
struct ValueLimits {
    AddressRange addresses;
    std::int32_t least = 0;  ///< below zero: the registers are read as int16, else as uint16
    std::int32_t greatest = 0xFFFF;
};

/// Coils or discrete inputs: the addresses first..first + count - 1, at most up to 65535.
struct BitBank {
    std::uint16_t first = 0;
    std::uint32_t count = 0;  ///< 0: the area is empty
    std::span<std::uint8_t>
        packed;               ///< at least ceil(count / 8) bytes; bit i of them is the address first + i
    AddressRanges offered;    ///< the addresses that exist; empty: the whole storage
    AddressRanges read_only;  ///< writes that touch one of these are refused
    std::optional<BitOverlay> overlay;  ///< the bits are those registers' and `packed` is not used; a bit
                                        ///< exists where its register does
    bool dense = false;                 ///< the storage holds the offered ranges one behind the other

    /// @param address  one that exists; not of an overlay: see Banks
    [[nodiscard]] bool get(std::uint16_t address) const;
    void set(std::uint16_t address, bool on);
};

/// Input or holding registers: the addresses first..first + values.size() - 1, at most up to 65535.
/// Two banks may share their values, so that input registers mirror holding registers.
struct RegisterBank {
    std::uint16_t first = 0;
    std::span<std::uint16_t> values;
    AddressRanges offered;                ///< as above
    AddressRanges read_only;              ///< as above
    std::span<const ValueLimits> limits;  ///< writes of other values are refused; lives as long as the bank
    bool dense = false;                   ///< as above

    /// @param address  one that exists
    [[nodiscard]] std::uint16_t get(std::uint16_t address) const;
    void set(std::uint16_t address, std::uint16_t value);
};

struct Banks {
    BitBank coils;
    BitBank discrete_inputs;
    RegisterBank input_registers;
    RegisterBank holding_registers;

    [[nodiscard]] BitBank& bits(wire::Area area);
    [[nodiscard]] const BitBank& bits(wire::Area area) const;
    [[nodiscard]] RegisterBank& registers(wire::Area area);
    [[nodiscard]] const RegisterBank& registers(wire::Area area) const;

    /// Whether all of start..start + count - 1 exist (writable(): and none is read-only). False if the range
    /// ends beyond 65535. count >= 1.
    [[nodiscard]] bool readable(wire::Area area, std::uint16_t start, std::uint16_t count) const;
    [[nodiscard]] bool writable(wire::Area area, std::uint16_t start, std::uint16_t count) const;

    /// An existing bit or register. Overlays are resolved.
    [[nodiscard]] bool bit(wire::Area area, std::uint16_t address) const;
    void set_bit(wire::Area area, std::uint16_t address, bool on);

    /// Whether the limits allow the values. `values` as on the wire: bits from the least significant one of
    /// the first byte on, registers high byte first.
    [[nodiscard]] bool admits(wire::Area area, std::uint16_t start, std::uint16_t count, Bytes values) const;
};

/// Whether all of start..start + count - 1 exist. False if the range ends beyond 65535. count >= 1. Overlays
/// are not resolved.
bool readable(const BitBank& bank, std::uint16_t start, std::uint16_t count);
bool readable(const RegisterBank& bank, std::uint16_t start, std::uint16_t count);

/// Whether all exist and none is read-only.
bool writable(const BitBank& bank, std::uint16_t start, std::uint16_t count);
bool writable(const RegisterBank& bank, std::uint16_t start, std::uint16_t count);

}  // namespace takt::serve
