// Frames as hex strings, for the tests of the room.
#pragma once

#include <cstdint>
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

}  // namespace takt::wire
