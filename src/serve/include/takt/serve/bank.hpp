// The four areas of a unit, on storage that the caller gives.
#pragma once

#include <cstdint>
#include <span>

namespace takt::serve {

/// Addresses first..last, both included.
struct AddressRange {
    std::uint16_t first = 0;
    std::uint16_t last = 0;
    friend constexpr bool operator==(const AddressRange&, const AddressRange&) = default;
};

/// Sorted by address and not overlapping; ranges may lie side by side. Lives as long as the bank.
using AddressRanges = std::span<const AddressRange>;

/// Coils or discrete inputs: the addresses first..first + count - 1, at most up to 65535.
struct BitBank {
    std::uint16_t first = 0;
    std::uint32_t count = 0;  ///< 0: the area is empty
    std::span<std::uint8_t>
        packed;               ///< at least ceil(count / 8) bytes; bit i of them is the address first + i
    AddressRanges offered;    ///< where given, only these addresses exist; empty: all of the storage
    AddressRanges read_only;  ///< writes that touch one of these are refused

    /// @param address  one that exists
    [[nodiscard]] bool get(std::uint16_t address) const;
    void set(std::uint16_t address, bool on);
};

/// Input or holding registers: the addresses first..first + values.size() - 1, at most up to 65535.
struct RegisterBank {
    std::uint16_t first = 0;
    std::span<std::uint16_t> values;
    AddressRanges offered;    ///< as above
    AddressRanges read_only;  ///< as above

    /// @param address  one that exists
    [[nodiscard]] std::uint16_t get(std::uint16_t address) const;
    void set(std::uint16_t address, std::uint16_t value);
};

struct Banks {
    BitBank coils;
    BitBank discrete_inputs;
    RegisterBank input_registers;
    RegisterBank holding_registers;
};

/// Whether all of start..start + count - 1 exist; never when that ends beyond 65535. count >= 1.
bool readable(const BitBank& bank, std::uint16_t start, std::uint16_t count);
bool readable(const RegisterBank& bank, std::uint16_t start, std::uint16_t count);

/// Whether they exist and none of them is read-only.
bool writable(const BitBank& bank, std::uint16_t start, std::uint16_t count);
bool writable(const RegisterBank& bank, std::uint16_t start, std::uint16_t count);

}  // namespace takt::serve
