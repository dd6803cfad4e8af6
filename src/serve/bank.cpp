#include "takt/serve/bank.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"

namespace takt::serve {
namespace {

constexpr unsigned kBitsInARegister = 16;

/// The first range whose end is not below `address`.
AddressRanges::iterator range_from(AddressRanges ranges, std::uint32_t address) {
    return std::partition_point(ranges.begin(), ranges.end(),
                                [address](const AddressRange& range) { return range.last < address; });
}

/// Whether each address of start..last lies in a range.
bool covers(AddressRanges ranges, std::uint32_t start, std::uint32_t last) {
    for (auto range = range_from(ranges, start); range != ranges.end() && range->first <= start; ++range) {
        if (range->last >= last) return true;
        start = range->last + 1U;
    }
    return false;
}

/// Whether some address of start..last lies in a range.
bool touches(AddressRanges ranges, std::uint32_t start, std::uint32_t last) {
    const auto range = range_from(ranges, start);
    return range != ranges.end() && range->first <= last;
}

std::uint32_t stored(const BitBank& bank) {
    return bank.count;
}
std::uint32_t stored(const RegisterBank& bank) {
    return static_cast<std::uint32_t>(bank.values.size());
}

template <class Bank>
bool bank_readable(const Bank& bank, std::uint16_t start, std::uint16_t count) {
    const std::uint32_t last = std::uint32_t{start} + count - 1;
    if (last > 0xFFFF) return false;
    if (bank.dense) return covers(bank.offered, start, last);
    if (start < bank.first || last >= bank.first + stored(bank)) return false;
    return bank.offered.empty() || covers(bank.offered, start, last);
}

template <class Bank>
bool bank_writable(const Bank& bank, std::uint16_t start, std::uint16_t count) {
    return bank_readable(bank, start, count) && !touches(bank.read_only, start, start + count - 1U);
}

/// The position of an item in the storage. A dense bank stores the offered ranges without gaps.
template <class Bank>
std::uint32_t index_of(const Bank& bank, std::uint16_t address) {
    if (!bank.dense) {
        TAKT_ASSERT(address >= bank.first && std::uint32_t{address} - bank.first < stored(bank));
        return std::uint32_t{address} - bank.first;
    }
    std::uint32_t index = 0;
    for (const AddressRange& range : bank.offered) {
        if (address <= range.last) {
            index += std::uint32_t{address} - range.first;
            break;
        }
        index += range.last - range.first + 1U;
    }
    TAKT_ASSERT(index < stored(bank));
    return index;
}

/// A bit of a register.
struct BitPosition {
    std::uint16_t address = 0;
    unsigned bit = 0;
};
BitPosition position_of(const BitBank& bank, std::uint16_t address) {
    const unsigned distance = unsigned{address} - bank.first;
    return {static_cast<std::uint16_t>(bank.overlay->first + distance / kBitsInARegister),
            distance % kBitsInARegister};
}

/// The registers of an overlay under a range of bits. `count` is 0 if the range leaves the bank.
struct Span {
    std::uint16_t start = 0;
    std::uint16_t count = 0;
};
Span registers_under(const BitBank& bank, std::uint16_t start, std::uint16_t count) {
    const std::uint32_t last = std::uint32_t{start} + count - 1;
    if (last > 0xFFFF || start < bank.first || last >= bank.first + bank.count) return {};
    if (!bank.offered.empty() && !covers(bank.offered, start, last)) return {};
    if (bank.overlay->first + (last - bank.first) / kBitsInARegister > 0xFFFF) return {};
    const std::uint16_t first = position_of(bank, start).address;
    const std::uint16_t end = position_of(bank, static_cast<std::uint16_t>(last)).address;
    return {first, static_cast<std::uint16_t>(end - first + 1)};
}

bool admits_value(const RegisterBank& bank, std::uint16_t address, unsigned value) {
    return std::ranges::all_of(bank.limits, [&](const ValueLimits& limits) {
        if (address < limits.addresses.first || address > limits.addresses.last) return true;
        const std::int32_t number =
            limits.least < 0 ? static_cast<std::int16_t>(value) : static_cast<std::int32_t>(value);
        return number >= limits.least && number <= limits.greatest;
    });
}

bool bit_at(Bytes packed, std::size_t index) {
    return (packed[index / 8] >> (index % 8) & 1) != 0;
}

}  // namespace

bool BitBank::get(std::uint16_t address) const {
    return bit_at(packed, index_of(*this, address));
}

void BitBank::set(std::uint16_t address, bool on) {
    const std::uint32_t index = index_of(*this, address);
    const auto mask = static_cast<std::uint8_t>(1U << (index % 8));
    auto& byte = packed[index / 8];
    byte = static_cast<std::uint8_t>(on ? byte | mask : byte & ~mask);
}

std::uint16_t RegisterBank::get(std::uint16_t address) const {
    return values[index_of(*this, address)];
}

void RegisterBank::set(std::uint16_t address, std::uint16_t value) {
    values[index_of(*this, address)] = value;
}

BitBank& Banks::bits(wire::Area area) {
    return area == wire::Area::coil ? coils : discrete_inputs;
}
const BitBank& Banks::bits(wire::Area area) const {
    return area == wire::Area::coil ? coils : discrete_inputs;
}
RegisterBank& Banks::registers(wire::Area area) {
    return area == wire::Area::input_register ? input_registers : holding_registers;
}
const RegisterBank& Banks::registers(wire::Area area) const {
    return area == wire::Area::input_register ? input_registers : holding_registers;
}

bool Banks::readable(wire::Area area, std::uint16_t start, std::uint16_t count) const {
    if (!wire::is_bit_area(area)) return bank_readable(registers(area), start, count);
    const BitBank& bank = bits(area);
    if (!bank.overlay) return bank_readable(bank, start, count);
    const Span under = registers_under(bank, start, count);
    return under.count > 0 && bank_readable(registers(bank.overlay->area), under.start, under.count);
}

bool Banks::writable(wire::Area area, std::uint16_t start, std::uint16_t count) const {
    if (!wire::is_bit_area(area)) return bank_writable(registers(area), start, count);
    const BitBank& bank = bits(area);
    if (!bank.overlay) return bank_writable(bank, start, count);
    const Span under = registers_under(bank, start, count);
    return under.count > 0 && bank_writable(registers(bank.overlay->area), under.start, under.count) &&
           !touches(bank.read_only, start, start + count - 1U);
}

bool Banks::bit(wire::Area area, std::uint16_t address) const {
    const BitBank& bank = bits(area);
    if (!bank.overlay) return bank.get(address);
    const BitPosition position = position_of(bank, address);
    return (registers(bank.overlay->area).get(position.address) >> position.bit & 1) != 0;
}

void Banks::set_bit(wire::Area area, std::uint16_t address, bool on) {
    BitBank& bank = bits(area);
    if (!bank.overlay) return bank.set(address, on);
    const BitPosition position = position_of(bank, address);
    RegisterBank& under = registers(bank.overlay->area);
    const unsigned mask = 1U << position.bit;
    const unsigned value = under.get(position.address);
    under.set(position.address, static_cast<std::uint16_t>(on ? value | mask : value & ~mask));
}

bool Banks::admits(wire::Area area, std::uint16_t start, std::uint16_t count, Bytes values) const {
    if (!wire::is_bit_area(area)) {
        const RegisterBank& bank = registers(area);
        for (std::size_t i = 0; i < count && !bank.limits.empty(); ++i)
            if (!admits_value(bank, static_cast<std::uint16_t>(start + i),
                              unsigned{values[2 * i]} << 8 | values[2 * i + 1]))
                return false;
        return true;
    }
    const BitBank& bank = bits(area);
    if (!bank.overlay || registers(bank.overlay->area).limits.empty()) return true;
    const RegisterBank& under = registers(bank.overlay->area);
    for (std::size_t i = 0; i < count;) {
        const BitPosition position = position_of(bank, static_cast<std::uint16_t>(start + i));
        unsigned value = under.get(position.address);
        for (unsigned bit = position.bit; bit < kBitsInARegister && i < count; ++bit, ++i)
            value = bit_at(values, i) ? value | 1U << bit : value & ~(1U << bit);
        if (!admits_value(under, position.address, value)) return false;
    }
    return true;
}

bool readable(const BitBank& bank, std::uint16_t start, std::uint16_t count) {
    return bank_readable(bank, start, count);
}
bool readable(const RegisterBank& bank, std::uint16_t start, std::uint16_t count) {
    return bank_readable(bank, start, count);
}
bool writable(const BitBank& bank, std::uint16_t start, std::uint16_t count) {
    return bank_writable(bank, start, count);
}
bool writable(const RegisterBank& bank, std::uint16_t start, std::uint16_t count) {
    return bank_writable(bank, start, count);
}

}  // namespace takt::serve
