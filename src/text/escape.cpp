#include "takt/text/escape.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "takt/base/utf8.hpp"

namespace takt::text {
namespace {

// Every byte of these texts is printable, so that nearly all texts are copied as they are.
bool is_plain(char c) {
    return c >= 0x20 && c < 0x7F;
}

void append_escaped(std::string& out, std::string_view text, const Character& character) {
    std::array<char, 16> escape{};
    switch (character.code) {
        case '\n': out += "\\n"; return;
        case '\r': out += "\\r"; return;
        case '\t': out += "\\t"; return;
        default: break;
    }
    if (character.bytes == 0)
        std::snprintf(escape.data(), escape.size(), "\\x%02X", static_cast<unsigned char>(text[0]));
    else
        std::snprintf(escape.data(), escape.size(), "\\u{%02X}", static_cast<unsigned>(character.code));
    out += escape.data();
}

std::string escape(std::string_view text, bool keep_line_feeds) {
    if (std::ranges::all_of(text, [&](char c) { return is_plain(c) || (keep_line_feeds && c == '\n'); }))
        return std::string(text);
    std::string out;
    out.reserve(text.size() + 16);
    while (!text.empty()) {
        const Character character = first_character(text);
        const std::size_t bytes = std::max<std::size_t>(character.bytes, 1);
        if (character.bytes > 0 &&
            (is_printable(character.code) || (keep_line_feeds && character.code == '\n')))
            out += text.substr(0, bytes);
        else
            append_escaped(out, text, character);
        text.remove_prefix(bytes);
    }
    return out;
}

}  // namespace

std::string escape_line(std::string_view text) {
    return escape(text, false);
}

std::string escape_lines(std::string_view text) {
    return escape(text, true);
}

}  // namespace takt::text
