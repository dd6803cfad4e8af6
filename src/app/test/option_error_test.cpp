#include "options/option_error.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string_view>
#include <utility>

namespace takt::app {
namespace option_error_test {

TEST(OptionError, NamesAndValuesAreTakenFromTheWordsOfTheParser) {
    EXPECT_EQ(option_error("START is required"), (OptionError{"app.option.required", {{"option", "START"}}}));
    EXPECT_EQ(option_error("--fill excludes FILE"),
              (OptionError{"app.option.excludes", {{"option", "--fill"}, {"other", "FILE"}}}));
    EXPECT_EQ(option_error("--unit: 1 required 0..255 missing"),
              (OptionError{"app.option.no_value", {{"option", "--unit"}}}));
}

TEST(OptionError, ATargetIsNamedWithTheReason) {
    const Error port{Code::out_of_range, "port", {99999, 1, 65535}};
    EXPECT_EQ(
        option_error_text(Texts(text::Language::english), target_error("TARGET", "tcp://h:99999", port)),
        "TARGET tcp://h:99999: port: the value 99999 is out of range, allowed: 1..65535");
    const Error scheme{Code::syntax, "h:502 → tcp://h:502", {}};
    EXPECT_EQ(option_error_text(Texts(text::Language::english), target_error("--target", "h:502", scheme)),
              "--target h:502: 'h:502' is not valid, correct form: tcp://h:502");
}

TEST(OptionError, AnOptionOfOtherToolsIsNamed) {
    constexpr std::array<std::string_view, 4> kOptions{"--version", "--for", "--unit", "--realtime"};
    for (const auto& [name, meant] : {std::pair{"--duration", "--for"},
                                      {"--time", "--for"},
                                      {"--slave", "--unit"},
                                      {"--slave-id", "--unit"},
                                      {"--Unit-ID", "--unit"},
                                      {"--versoin", "--version"}})
        EXPECT_EQ(unknown_option(name, kOptions),
                  (OptionError{"app.option.unknown", {{"value", name}, {"nearest", meant}}}));
    constexpr std::array<std::string_view, 1> kOthers{"--version"};
    EXPECT_EQ(unknown_option("--seconds", kOthers).code, "app.option.unknown.unlike");
}

TEST(OptionError, OtherWordsAreKept) {
    EXPECT_EQ(option_error("words: unknown"),
              (OptionError{"app.option.other", {{"words", "words: unknown"}}}));
}

}  // namespace option_error_test
}  // namespace takt::app
