// Unsigned decimal numbers.
#pragma once

#include <charconv>
#include <cstdint>
#include <optional>
#include <string_view>

namespace takt::bus {

/// The number that `text` is, digits alone; nothing for anything else and for more than 32 bits.
inline std::optional<std::uint32_t> parse_decimal(std::string_view text) {
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (text.empty() || end != text.data() + text.size() || error != std::errc{}) return std::nullopt;
    return value;
}

}  // namespace takt::bus
