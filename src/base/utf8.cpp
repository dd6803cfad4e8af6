#include "takt/base/utf8.hpp"

#include <cstdint>

namespace takt {

// Overlong forms, surrogates and codes above U+10FFFF are not UTF-8 (RFC 3629, section 3).
Character first_character(std::string_view text) {
    const auto byte = [&](std::size_t i) -> std::uint32_t { return static_cast<unsigned char>(text[i]); };
    const std::uint32_t first = byte(0);
    if (first < 0x80) return {first, 1};
    const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
    if (first < 0xC2 || first > 0xF4 || text.size() < length) return {first, 0};
    std::uint32_t code = first & (0x7FU >> length);
    for (std::size_t i = 1; i < length; ++i) {
        if (!continues_character(text[i])) return {first, 0};
        code = code << 6U | (byte(i) & 0x3FU);
    }
    static constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
    const bool surrogate = code >= 0xD800 && code < 0xE000;
    if (code < kLeast[length] || code > 0x10FFFF || surrogate) return {first, 0};
    return {code, length};
}

InplaceString<4> encoded(char32_t code) {
    const auto continued = [code](unsigned shift) {
        return static_cast<char>(0x80U | (code >> shift & 0x3FU));
    };
    const char bytes[] = {static_cast<char>(0xF0U | code >> 18U), continued(12), continued(6), continued(0)};
    if (code >= 0x10000) return std::string_view(bytes, 4);
    const char three[] = {static_cast<char>(0xE0U | code >> 12U), bytes[2], bytes[3]};
    if (code >= 0x800) return std::string_view(three, 3);
    const char two[] = {static_cast<char>(0xC0U | code >> 6U), bytes[3]};
    if (code >= 0x80) return std::string_view(two, 2);
    const char one = static_cast<char>(code);
    return std::string_view(&one, 1);
}

bool is_printable(char32_t code) {
    if (code < 0x20 || (code >= 0x7F && code < 0xA0)) return false;
    const bool separator = code == 0x2028 || code == 0x2029;
    const bool bidirectional = code == 0x61C || code == 0x200E || code == 0x200F ||
                               (code >= 0x202A && code <= 0x202E) || (code >= 0x2066 && code <= 0x2069);
    return !separator && !bidirectional;
}

}  // namespace takt
