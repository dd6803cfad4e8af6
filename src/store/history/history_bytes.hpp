// Variable-length integers of the history's formats (LEB128; signed numbers as zigzag).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/engine.hpp"

namespace takt::store {

using ByteVector = std::vector<std::uint8_t>;

inline void put_varint(ByteVector& out, std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) out.push_back(static_cast<std::uint8_t>(value | 0x80));
    out.push_back(static_cast<std::uint8_t>(value));
}

constexpr std::uint64_t zigzag(std::int64_t value) {
    return (static_cast<std::uint64_t>(value) << 1) ^ static_cast<std::uint64_t>(value >> 63);
}
constexpr std::int64_t from_zigzag(std::uint64_t value) {
    return static_cast<std::int64_t>(value >> 1) ^ -static_cast<std::int64_t>(value & 1);
}

inline void put_signed(ByteVector& out, std::int64_t value) {
    put_varint(out, zigzag(value));
}

inline void put_text(ByteVector& out, std::string_view text) {
    put_varint(out, text.size());
    out.insert(out.end(), text.begin(), text.end());
}

/// a - b and a + b modulo 2^64: differences of any two numbers can be undone.
constexpr std::int64_t wrapped_difference(std::int64_t a, std::int64_t b) {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
}
constexpr std::int64_t wrapped_sum(std::int64_t a, std::int64_t b) {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
}

/// The history keeps times in milliseconds. Rounded down.
constexpr std::int64_t milliseconds(std::int64_t ns) {
    return ns / 1'000'000 - (ns % 1'000'000 < 0 ? 1 : 0);
}
/// Modulo 2^64: damaged bytes may hold any number.
constexpr std::int64_t nanoseconds(std::int64_t ms) {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(ms) * 1'000'000U);
}

/// Takes numbers from the beginning of bytes. After the first one that is not there, good() is false and all
/// others are 0.
class VarintReader {
public:
    explicit VarintReader(Bytes bytes) : bytes_(bytes) {}

    [[nodiscard]] bool good() const { return good_; }
    [[nodiscard]] std::size_t left() const { return bytes_.size(); }

    std::uint64_t take() {
        std::uint64_t value = 0;
        for (unsigned shift = 0; shift < 64; shift += 7) {
            if (bytes_.empty()) break;
            const std::uint8_t byte = bytes_.front();
            bytes_ = bytes_.subspan(1);
            value |= std::uint64_t{byte & 0x7FU} << shift;
            if (byte < 0x80) return value;
        }
        fail();
        return 0;
    }
    std::int64_t take_signed() { return from_zigzag(take()); }
    /// @returns a part of the bytes; empty where there are fewer
    Bytes take_bytes(std::uint64_t count) {
        if (count > bytes_.size()) {
            fail();
            return {};
        }
        const Bytes taken = bytes_.first(static_cast<std::size_t>(count));
        bytes_ = bytes_.subspan(taken.size());
        return taken;
    }
    std::string take_text() {
        const Bytes text = take_bytes(take());
        return {text.begin(), text.end()};
    }
    void fail() {
        good_ = false;
        bytes_ = {};
    }

private:
    Bytes bytes_;
    bool good_ = true;
};

}  // namespace takt::store
