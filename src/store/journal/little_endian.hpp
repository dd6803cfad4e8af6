// Integers in files, little endian.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "takt/base/assert.hpp"
#include "takt/base/engine.hpp"

namespace takt::store {

template <std::unsigned_integral T>
void put_little(std::vector<std::uint8_t>& out, T value) {
    std::array<std::uint8_t, sizeof value> bytes;
    for (std::size_t i = 0; i < sizeof value; ++i)
        bytes[i] = static_cast<std::uint8_t>(std::uint64_t{value} >> 8 * i);
    out.insert(out.end(), bytes.begin(), bytes.end());
}

/// Takes integers from the beginning of bytes. The caller checks the size before.
class LittleEndianReader {
public:
    explicit LittleEndianReader(Bytes bytes) : bytes_(bytes) {}

    template <std::unsigned_integral T>
    [[nodiscard]] T take() {
        TAKT_ASSERT(bytes_.size() >= sizeof(T));
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < sizeof(T); ++i) value |= std::uint64_t{bytes_[i]} << 8 * i;
        bytes_ = bytes_.subspan(sizeof(T));
        return static_cast<T>(value);
    }

private:
    Bytes bytes_;
};

}  // namespace takt::store
