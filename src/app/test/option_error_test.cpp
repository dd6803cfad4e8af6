#include "options/option_error.hpp"

#include <gtest/gtest.h>

namespace takt::app {
namespace {

TEST(OptionError, NamesAndValuesAreTakenFromTheWordsOfTheParser) {
    EXPECT_EQ(option_error("START is required"), (OptionError{"app.option.required", {{"option", "START"}}}));
    EXPECT_EQ(option_error("--fill excludes FILE"),
              (OptionError{"app.option.excludes", {{"option", "--fill"}, {"other", "FILE"}}}));
    EXPECT_EQ(option_error("--unit: 1 required 0..255 missing"),
              (OptionError{"app.option.no_value", {{"option", "--unit"}}}));
}

TEST(OptionError, OtherWordsAreKept) {
    EXPECT_EQ(option_error("words: unknown"),
              (OptionError{"app.option.other", {{"words", "words: unknown"}}}));
}

}  // namespace
}  // namespace takt::app
