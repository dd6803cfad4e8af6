#include "takt/text/escape.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "takt/base/utf8.hpp"
#include "takt/text/catalogue.hpp"

namespace takt::text {
namespace escape_test {

using namespace std::string_literals;

TEST(EscapeLine, LeavesNothingThatATerminalObeys) {
    const std::pair<std::string, std::string> cases[] = {
        {"", ""},
        {"Level 12.5 °C, уровень, рівень", "Level 12.5 °C, уровень, рівень"},
        {"C:\\temp", "C:\\temp"},
        {"a\nb\r\tc", "a\\nb\\r\\tc"},
        {"\x1B[2J\x07", "\\u{1B}[2J\\u{07}"},
        {"a\0b"s, "a\\u{00}b"},
        {"\x7F", "\\u{7F}"},
        {"\xC2\x9B"
         "31m",
         "\\u{9B}31m"},
        {"\xE2\x80\xAE"
         "txt.exe",
         "\\u{202E}txt.exe"},
        {"\xE2\x80\xA8", "\\u{2028}"},
        {"\xE2\x81\xA6", "\\u{2066}"},
        {"\xFF\xC3", "\\xFF\\xC3"},
        {"\xC0\xAF", "\\xC0\\xAF"},                    // an overlong form of "/"
        {"\xED\xA0\x80", "\\xED\\xA0\\x80"},           // a surrogate
        {"\xF4\x90\x80\x80", "\\xF4\\x90\\x80\\x80"},  // above U+10FFFF
        {"\xE2\x82\xAC \xF0\x9F\x94\xA5", "\xE2\x82\xAC \xF0\x9F\x94\xA5"},
    };
    for (const auto& [text, escaped] : cases) EXPECT_EQ(escape_line(text), escaped);
}

TEST(EscapeLines, KeepsLineFeedsOnly) {
    EXPECT_EQ(escape_lines("a\r\nb\x1B\n"), "a\\r\nb\\u{1B}\n");
}

RC_GTEST_PROP(EscapeLine, IsPrintableAndStaysAsItIs, ()) {
    const auto text = *rc::gen::container<std::string>(rc::gen::oneOf(
        rc::gen::arbitrary<char>(), rc::gen::element('\xC2', '\x9B', '\xE2', '\x80', '\xAE', '\n', 'a')));
    const std::string escaped = escape_line(text);
    for (std::string_view rest = escaped; !rest.empty();) {
        const Character character = first_character(rest);
        RC_ASSERT(character.bytes > 0u);
        RC_ASSERT(is_printable(character.code));
        rest.remove_prefix(character.bytes);
    }
    RC_ASSERT(escape_line(escaped) == escaped);
}

TEST(Message, EscapesItsArguments) {
    const Argument arguments[] = {{"file", "a\x1B[31m\nb"}};
    EXPECT_NE(message(Language::english, "app.access.kept", arguments).find("a\\u{1B}[31m\\nb"),
              std::string::npos);
    EXPECT_NE(message(Language::english, "no.such.code", arguments).find("a\\u{1B}[31m\\nb"),
              std::string::npos);
}

}  // namespace escape_test
}  // namespace takt::text
