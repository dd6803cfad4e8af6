#include "takt/base/utf8.hpp"

#include <gtest/gtest.h>

#include <string>

namespace takt {
namespace utf8_test {

TEST(Utf8, EveryCharacterIsDecodedAsItWasEncoded) {
    for (char32_t code = 0; code <= 0x10FFFF; ++code) {
        if (code == 0xD800) code = 0xE000;
        const auto bytes = encoded(code);
        const Character character = first_character(bytes.view());
        ASSERT_EQ(character.code, code);
        ASSERT_EQ(character.bytes, bytes.size());
        ASSERT_EQ(count_characters(bytes.view()), 1U);
    }
}

TEST(Utf8, EncodesInTheShortestForm) {
    EXPECT_EQ(encoded(U'a').view(), "a");
    EXPECT_EQ(encoded(U'ё').view(), "ё");
    EXPECT_EQ(encoded(U'€').view(), "€");
    EXPECT_EQ(encoded(0x1F525).view(), "\xF0\x9F\x94\xA5");
}

TEST(Utf8, InvalidTextHasNoFirstCharacter) {
    for (const std::string_view text :
         {"\x80", "\xC3", "\xC0\xAF", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xFF"})
        EXPECT_EQ(first_character(text).bytes, 0U) << text;
}

TEST(Utf8, CountsCodePoints) {
    EXPECT_EQ(count_characters(""), 0U);
    EXPECT_EQ(count_characters("Boiler"), 6U);
    EXPECT_EQ(count_characters("Котёл"), 5U);
    EXPECT_EQ(count_characters("°C"), 2U);
}

TEST(Utf8, TextIsCutBetweenCharacters) {
    EXPECT_EQ(whole_characters("abc", 3), "abc");
    EXPECT_EQ(whole_characters("abc", 2), "ab");
    EXPECT_EQ(whole_characters("aёb", 2), "a");
    EXPECT_EQ(whole_characters("aёb", 3), "aё");
    EXPECT_EQ(whole_characters("€", 2), "");
    EXPECT_EQ(whole_characters("€", 0), "");
}

}  // namespace utf8_test
}  // namespace takt
