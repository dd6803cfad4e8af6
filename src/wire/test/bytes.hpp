// Frames as hex strings, for the tests of the room.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/engine.hpp"

namespace takt::wire {

using ByteVector = std::vector<std::uint8_t>;

/// "10 03 00" or "1003 00" as bytes.
inline ByteVector from_hex(std::string_view text) {
    ByteVector bytes;
    std::string digits;
    for (const char c : text)
        if (c != ' ') digits.push_back(c);
    for (std::size_t i = 0; i + 1 < digits.size(); i += 2)
        bytes.push_back(static_cast<std::uint8_t>(std::stoul(digits.substr(i, 2), nullptr, 16)));
    return bytes;
}

/// "10 03 00".
inline std::string to_hex(Bytes bytes) {
    constexpr std::string_view kDigits = "0123456789ABCDEF";
    std::string text;
    for (const std::uint8_t byte : bytes) {
        if (!text.empty()) text += ' ';
        text += kDigits[byte >> 4];
        text += kDigits[byte & 0xF];
    }
    return text;
}

/// A copy in a heap block of exactly its size: a sanitizer sees every step beyond the end.
class ExactBytes {
public:
    explicit ExactBytes(Bytes bytes) : bytes_(new std::uint8_t[bytes.size()]), size_(bytes.size()) {
        std::ranges::copy(bytes, bytes_.get());
    }
    operator Bytes() const { return {bytes_.get(), size_}; }  // NOLINT(*-explicit-*): stands for its bytes

private:
    std::unique_ptr<std::uint8_t[]> bytes_;
    std::size_t size_;
};

}  // namespace takt::wire
