#include "takt/text/catalogue.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

namespace takt::text {
namespace catalogue_test {

std::set<std::string_view> placeholders(std::string_view pattern) {
    constexpr std::string_view kNameCharacters = "abcdefghijklmnopqrstuvwxyz0123456789_";
    std::set<std::string_view> found;
    for (auto open = pattern.find('{'); open != std::string_view::npos; open = pattern.find('{', open + 1)) {
        const auto name = pattern.substr(open + 1, pattern.find('}', open) - open - 1);
        if (name.find_first_not_of(kNameCharacters) == std::string_view::npos) found.insert(name);
    }
    return found;
}

TEST(Catalogue, LanguagesHaveTheSameCodesAndPlaceholders) {
    const auto all = codes(Language::english);
    ASSERT_FALSE(all.empty());
    for (const auto language : kLanguages) {
        EXPECT_EQ(codes(language), all) << tag(language);
        for (const auto code : all)
            EXPECT_EQ(placeholders(pattern(language, code)), placeholders(pattern(Language::english, code)))
                << tag(language) << " " << code;
    }
}

// "{local} → 1" has none.
bool has_words(std::string_view pattern) {
    bool inside = false;
    return std::ranges::any_of(pattern, [&](char c) {
        if (c == '{' || c == '}') inside = c == '{';
        return !inside && c >= 'a' && c <= 'z';
    });
}

TEST(Catalogue, TranslationsDiffer) {
    for (const auto code : codes(Language::english)) {
        if (!has_words(pattern(Language::english, code))) continue;
        EXPECT_NE(pattern(Language::russian, code), pattern(Language::english, code)) << code;
        EXPECT_NE(pattern(Language::ukrainian, code), pattern(Language::english, code)) << code;
    }
}

TEST(Catalogue, EveryAdviceBelongsToAMessage) {
    constexpr std::string_view kEnding = ".advice";
    for (auto code : codes(Language::english))
        if (code.ends_with(kEnding)) {
            code.remove_suffix(kEnding.size());
            EXPECT_TRUE(has(Language::english, code)) << code;
        }
}

TEST(Catalogue, FillsPlaceholdersInOnePass) {
    const std::array arguments{Argument{"value", "{least}"}, Argument{"least", "1"},
                               Argument{"greatest", "9"}};
    EXPECT_EQ(message(Language::english, "error.out_of_range.numbers", arguments),
              "the value {least} is out of range, allowed: 1..9");
    EXPECT_EQ(message(Language::russian, "error.out_of_range.numbers", arguments),
              "значение {least} вне допустимого диапазона, допустимо: 1..9");
    EXPECT_EQ(message(Language::english, "error.out_of_range"), "the value {value} is out of range");
}

TEST(Catalogue, AnUnknownCodeStandsForItself) {
    EXPECT_FALSE(has(Language::ukrainian, "field.odd"));
    EXPECT_EQ(pattern(Language::english, "field.odd"), "");
    EXPECT_EQ(message(Language::ukrainian, "field.odd"), "field.odd");
    EXPECT_EQ(message(Language::ukrainian, "field.odd",
                      std::array{Argument{"value", "7"}, Argument{"allowed", "0..5"}}),
              "field.odd (value: 7, allowed: 0..5)");
}

}  // namespace catalogue_test
}  // namespace takt::text
