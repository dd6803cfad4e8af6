// Detection of the encoding: UTF-8 with a byte order mark is UTF-8. Otherwise the bytes outside ASCII decide:
// more bytes that break UTF-8 than whole UTF-8 characters mean CP1251.
//
// CP1251 has its own table here, because the encodings of iconv depend on modules that a small system may
// lack.
#include "tables/encoding.hpp"

#include <algorithm>
#include <array>

#include "takt/base/utf8.hpp"
#include "yaml/source.hpp"

namespace takt::file {
namespace {

constexpr unsigned kFirstOther = 0x80;  // below it is ASCII

// Characters of the bytes from 0x80 on; 0: the byte is undefined.
constexpr std::array<char16_t, 128> kCp1251{
    0x0402, 0x0403, 0x201A, 0x0453, 0x201E, 0x2026, 0x2020, 0x2021, 0x20AC, 0x2030, 0x0409, 0x2039, 0x040A,
    0x040C, 0x040B, 0x040F, 0x0452, 0x2018, 0x2019, 0x201C, 0x201D, 0x2022, 0x2013, 0x2014, 0x0000, 0x2122,
    0x0459, 0x203A, 0x045A, 0x045C, 0x045B, 0x045F, 0x00A0, 0x040E, 0x045E, 0x0408, 0x00A4, 0x0490, 0x00A6,
    0x00A7, 0x0401, 0x00A9, 0x0404, 0x00AB, 0x00AC, 0x00AD, 0x00AE, 0x0407, 0x00B0, 0x00B1, 0x0406, 0x0456,
    0x0491, 0x00B5, 0x00B6, 0x00B7, 0x0451, 0x2116, 0x0454, 0x00BB, 0x0458, 0x0405, 0x0455, 0x0457, 0x0410,
    0x0411, 0x0412, 0x0413, 0x0414, 0x0415, 0x0416, 0x0417, 0x0418, 0x0419, 0x041A, 0x041B, 0x041C, 0x041D,
    0x041E, 0x041F, 0x0420, 0x0421, 0x0422, 0x0423, 0x0424, 0x0425, 0x0426, 0x0427, 0x0428, 0x0429, 0x042A,
    0x042B, 0x042C, 0x042D, 0x042E, 0x042F, 0x0430, 0x0431, 0x0432, 0x0433, 0x0434, 0x0435, 0x0436, 0x0437,
    0x0438, 0x0439, 0x043A, 0x043B, 0x043C, 0x043D, 0x043E, 0x043F, 0x0440, 0x0441, 0x0442, 0x0443, 0x0444,
    0x0445, 0x0446, 0x0447, 0x0448, 0x0449, 0x044A, 0x044B, 0x044C, 0x044D, 0x044E, 0x044F,
};

std::uint8_t byte_of(char c) {
    return static_cast<std::uint8_t>(c);
}

std::optional<char> cp1251_of(char32_t character) {
    if (character < kFirstOther) return static_cast<char>(character);
    const auto* const found = std::ranges::find(kCp1251, character);
    if (found == kCp1251.end()) return std::nullopt;
    return static_cast<char>(kFirstOther + static_cast<unsigned>(found - kCp1251.begin()));
}

}  // namespace

Encoding encoding_of(std::string_view bytes) {
    if (bytes.starts_with(kByteOrderMark)) return Encoding::utf8;
    std::size_t whole = 0;
    std::size_t broken = 0;
    for (std::size_t at = 0; at < bytes.size();) {
        const auto size = first_character(bytes.substr(at)).bytes;
        if (size == 0) ++broken;
        if (size > 1) ++whole;
        at += std::max<std::size_t>(size, 1);
    }
    return broken > whole ? Encoding::cp1251 : Encoding::utf8;
}

Decoded to_utf8(std::string_view bytes, Encoding encoding) {
    Decoded decoded;
    if (encoding == Encoding::utf8) {
        decoded.text = bytes;
        return decoded;
    }
    decoded.text.reserve(bytes.size() + bytes.size() / 2);
    for (const char c : bytes) {
        const char32_t character = byte_of(c) < kFirstOther ? byte_of(c) : kCp1251[byte_of(c) - kFirstOther];
        if (character == 0 && c != 0) {
            decoded.stopped_at = Foreign{decoded.text.size(), false, byte_of(c)};
            return decoded;
        }
        decoded.text += encoded(character).view();
    }
    return decoded;
}

std::optional<std::string> to_cp1251(std::string_view text) {
    std::string bytes;
    bytes.reserve(text.size());
    for (std::size_t at = 0; at < text.size();) {
        const auto character = first_character(text.substr(at));
        const auto coded = character.bytes > 0 ? cp1251_of(character.code) : std::nullopt;
        if (!coded) return std::nullopt;
        bytes += *coded;
        at += character.bytes;
    }
    return bytes;
}

std::string_view first_beyond_cp1251(std::string_view text) {
    for (std::size_t at = 0; at < text.size();) {
        const auto character = first_character(text.substr(at));
        const auto size = std::max<std::size_t>(character.bytes, 1);
        if (character.bytes == 0 || !cp1251_of(character.code)) return text.substr(at, size);
        at += size;
    }
    return {};
}

}  // namespace takt::file
