#include "takt/text/language.hpp"

#include <gtest/gtest.h>

namespace takt::text {
namespace language_test {

TEST(Language, IsReadFromTagsAndLocales) {
    struct Case {
        std::string_view text;
        std::optional<Language> language;
    };
    constexpr Case kCases[] = {
        {"en", Language::english},
        {"ru", Language::russian},
        {"uk", Language::ukrainian},
        {"RU", Language::russian},
        {"ru_RU.UTF-8", Language::russian},
        {"uk-UA", Language::ukrainian},
        {"uk_UA@x", Language::ukrainian},
        {"en_GB", Language::english},
        {"", std::nullopt},
        {"de_DE.UTF-8", std::nullopt},
        {"rum", std::nullopt},
        {"C", std::nullopt},
    };
    for (const auto& [text, expected] : kCases) EXPECT_EQ(language(text), expected) << text;
    for (const auto each : kLanguages) EXPECT_EQ(language(tag(each)), each);
}

TEST(Language, OfTheEnvironmentIsThatOfGettext) {
    struct Case {
        Environment environment;
        Language language;
    };
    constexpr Case kCases[] = {
        {{}, Language::english},
        {{.lang = "ru_RU.UTF-8"}, Language::russian},
        {{.lang = "de_DE.UTF-8"}, Language::english},
        {{.lc_messages = "uk_UA", .lang = "ru_RU"}, Language::ukrainian},
        {{.lc_all = "en_US", .lc_messages = "uk_UA", .lang = "ru_RU"}, Language::english},
        {{.lc_all = "C", .lang = "ru_RU"}, Language::english},
        {{.language = "de:uk:ru", .lang = "ru_RU"}, Language::ukrainian},
        {{.language = "de", .lang = "ru_RU"}, Language::russian},
        {{.language = "ru", .lang = "de_DE"}, Language::russian},
        {{.language = "ru"}, Language::english},
        {{.language = "ru", .lang = "C.UTF-8"}, Language::english},
    };
    for (const auto& each : kCases)
        EXPECT_EQ(language(each.environment), each.language)
            << each.environment.language << " " << each.environment.lc_all << " " << each.environment.lang;
}

}  // namespace language_test
}  // namespace takt::text
