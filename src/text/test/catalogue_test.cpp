#include "takt/text/catalogue.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <tuple>

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
        const auto english = pattern(Language::english, code);
        if (!has_words(english)) continue;
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

TEST(Catalogue, PluralFormsFollowTheNumber) {
    const auto at_most = [](Language language, const char* count) {
        return message(language, "app.learnt.most_items", std::array{Argument{"count", count}});
    };
    EXPECT_EQ(at_most(Language::english, "1"), "longest read: 1 item");
    EXPECT_EQ(at_most(Language::english, "21"), "longest read: 21 items");
    const auto exchanges = [](Language language, const char* count) {
        const std::string text =
            message(language, "app.turnaround.learnt", std::array{Argument{"count", count}});
        return text.substr(text.rfind(' ') + 1);
    };
    for (const auto& [count, russian, ukrainian] : {std::tuple{"1", "обмен", "обмін"},
                                                    {"3", "обмена", "обміни"},
                                                    {"5", "обменов", "обмінів"},
                                                    {"11", "обменов", "обмінів"},
                                                    {"112", "обменов", "обмінів"},
                                                    {"1021", "обмен", "обмін"},
                                                    {"1..3", "обмена", "обміни"},
                                                    {"0", "обменов", "обмінів"}}) {
        EXPECT_EQ(exchanges(Language::russian, count), russian) << count;
        EXPECT_EQ(exchanges(Language::ukrainian, count), ukrainian) << count;
    }
}

TEST(Catalogue, EachPluralHasItsForms) {
    for (const auto language : kLanguages)
        for (const auto code : codes(language)) {
            const auto text = pattern(language, code);
            for (auto open = text.find('{'); open != std::string_view::npos;
                 open = text.find('{', open + 1)) {
                const auto place = text.substr(open, text.find('}', open) - open);
                const auto forms = std::ranges::count(place, '|');
                if (forms > 0) {
                    EXPECT_EQ(forms, language == Language::english ? 2 : 3) << code;
                }
            }
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
