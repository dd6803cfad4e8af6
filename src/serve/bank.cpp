#include "takt/serve/bank.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"

namespace takt::serve {
namespace {

/// The first range that ends at `address` or behind it.
AddressRanges::iterator range_from(AddressRanges ranges, std::uint32_t address) {
    return std::partition_point(ranges.begin(), ranges.end(),
                                [address](const AddressRange& range) { return range.last < address; });
}

/// Whether every address of start..last lies in some range.
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

bool exist(std::uint32_t first, std::uint32_t stored, AddressRanges offered, std::uint32_t start,
           std::uint32_t count) {
    const std::uint32_t last = start + count - 1;
    if (last > 0xFFFF || start < first || last >= first + stored) return false;
    return offered.empty() || covers(offered, start, last);
}

std::uint32_t stored(const BitBank& bank) {
    return bank.count;
}
std::uint32_t stored(const RegisterBank& bank) {
    return static_cast<std::uint32_t>(bank.values.size());
}

template <class Bank>
bool bank_readable(const Bank& bank, std::uint16_t start, std::uint16_t count) {
    return exist(bank.first, stored(bank), bank.offered, start, count);
}

template <class Bank>
bool bank_writable(const Bank& bank, std::uint16_t start, std::uint16_t count) {
    return bank_readable(bank, start, count) && !touches(bank.read_only, start, start + count - 1U);
}

}  // namespace

bool BitBank::get(std::uint16_t address) const {
    const std::uint32_t index = std::uint32_t{address} - first;
    TAKT_ASSERT(address >= first && index < count);
    return (packed[index / 8] >> (index % 8) & 1) != 0;
}

void BitBank::set(std::uint16_t address, bool on) {
    const std::uint32_t index = std::uint32_t{address} - first;
    TAKT_ASSERT(address >= first && index < count);
    const auto mask = static_cast<std::uint8_t>(1U << (index % 8));
    auto& byte = packed[index / 8];
    byte = static_cast<std::uint8_t>(on ? byte | mask : byte & ~mask);
}

std::uint16_t RegisterBank::get(std::uint16_t address) const {
    TAKT_ASSERT(address >= first && std::size_t{address} - first < values.size());
    return values[std::size_t{address} - first];
}

void RegisterBank::set(std::uint16_t address, std::uint16_t value) {
    TAKT_ASSERT(address >= first && std::size_t{address} - first < values.size());
    values[std::size_t{address} - first] = value;
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
