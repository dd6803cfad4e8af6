#include "takt/report/drawing/word_wrap.hpp"

#include <gtest/gtest.h>

namespace takt::report {
namespace word_wrap_test {

TEST(WordWrap, BreaksLongLinesAtBlanks) {
    const struct {
        std::string_view text, expected;
    } cases[] = {
        {"", ""},
        {"\n\n", "\n\n"},
        {"0123456789", "0123456789"},
        {"abcde fghi jklm\n", "abcde fghi\n    jklm\n"},
        {"abcde fghijk", "abcde\n    fghijk"},
        {"a b\n  cc dd ee ff\n", "a b\n  cc dd ee\n      ff\n"},
        {"a bb  c   dddd", "a bb  c\n    dddd"},
        {"длинные слова", "длинные\n    слова"},
    };
    for (const auto& [text, expected] : cases) EXPECT_EQ(wrapped(text, 10), expected) << text;
}

TEST(WordWrap, AWordLongerThanALineStaysWhole) {
    EXPECT_EQ(wrapped("/a/very/long/path", 10), "/a/very/long/path");
    EXPECT_EQ(wrapped("/a/very/long/path is missing", 10), "/a/very/long/path\n    is\n    missing");
    EXPECT_EQ(wrapped("  /a/very/long/path", 4), "  /a/very/long/path");
    EXPECT_EQ(wrapped("trailing   ", 4), "trailing   ");
    EXPECT_EQ(wrapped("a b", 0), "a\n    b");
}

TEST(WordWrap, TheRestIsBelowTheSecondColumn) {
    EXPECT_EQ(wrapped("  --for  until the end of it", 20), "  --for  until the\n         end of it");
    EXPECT_EQ(wrapped("  --for-so-long  until the end", 20), "  --for-so-long\n      until the end")
        << "no room below it";
}

TEST(WordWrap, ANumberKeepsItsUnit) {
    EXPECT_EQ(wrapped("busy 20.7 %", 10), "busy\n    20.7 %");
    EXPECT_EQ(wrapped("period  # was 5 s", 10), "period\n    # was\n    5 s");
    EXPECT_EQ(wrapped("1 2 3", 2), "1 2 3") << "no other blank";
}

TEST(WordWrap, ALineThatFitsKeepsItsBlanks) {
    EXPECT_EQ(wrapped("a   b\n    c d \n", 10), "a   b\n    c d \n");
}

}  // namespace word_wrap_test
}  // namespace takt::report
