#include "options/option_error.hpp"

#include <gtest/gtest.h>

namespace takt::app {
namespace {

TEST(OptionError, KnownWordsAreTranslatedAndOthersKept) {
    const Texts texts(text::Language::russian);
    const auto shown = option_error(texts, "--unit: Value 256 not in range 0 to 255");
    EXPECT_NE(shown.find("256"), std::string::npos);
    EXPECT_NE(shown.find("0..255"), std::string::npos);
    EXPECT_NE(shown.find("допустимо"), std::string::npos);
    EXPECT_EQ(option_error(texts, "words: nobody knows"), "words: nobody knows");
}

}  // namespace
}  // namespace takt::app
