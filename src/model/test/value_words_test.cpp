#include "takt/model/value_words.hpp"

#include <gtest/gtest.h>

#include "findings_text.hpp"
#include "flow.hpp"

namespace takt::model {
namespace value_words_test {

using namespace test;

TEST(ValueWords, OfNumbersAndBits) {
    const auto checked = interpret(document(
        {.variable = "{type: int16, enumeration: {0: off, -1: broken}, bits: {0: a, 15: z, 3: c}}"}));
    ASSERT_EQ(findings_text(checked), "");
    const auto& variable = checked.project.lines[0].devices[0].variables[0];
    EXPECT_EQ(words_of(variable, 0), "off");
    EXPECT_EQ(words_of(variable, -1), "broken") << "the word of a number goes before names of bits";
    EXPECT_EQ(words_of(variable, 9), "a, c");
    EXPECT_EQ(words_of(variable, -32768), "z");
    EXPECT_EQ(words_of(variable, 2), "");
    EXPECT_EQ(text_of(variable.enumeration), "-1=broken, 0=off");
}

TEST(ValueWords, OfACell) {
    const auto checked = interpret(document({.variable = "{enumeration: \"0 = off; 1: on, 0x10=x\"}"}));
    ASSERT_EQ(findings_text(checked), "");
    EXPECT_EQ(text_of(checked.project.lines[0].devices[0].variables[0].enumeration), "0=off, 1=on, 16=x");
}

TEST(ValueWords, MistakesAreFindings) {
    const std::pair<std::string_view, std::string_view> cases[] = {
        {"{enumeration: {a: off}}", "words.malformed enumeration=a: off [1..64]"},
        {"{enumeration: {0: }}", "words.malformed enumeration=0 [1..64]"},
        {"{enumeration: \"off\"}", "words.malformed enumeration=off [1..64]"},
        {"{enumeration: {0: off, 0x0: on}}", "words.twice enumeration=0x0"},
        {"{enumeration: {40000: x}}", "field.out_of_range enumeration=40000 [-32768..32767]"},
        {"{bits: {16: x}}", "field.out_of_range bits=16 [0..15]"},
        {"{type: uint32, bits: {31: x}}", ""},
        {"{type: float, enumeration: {0: off}}", "words.type enumeration="},
        {"{scale: 0.1, bits: {0: off}}", "words.type bits="},
        {"{type: bool, bit: 0, bits: {0: off}}", "words.type bits="},
        {"{type: bool, bit: 0, enumeration: {0: off, 1: on}}", ""},
    };
    for (const auto& [keys, expected] : cases) EXPECT_EQ(findings_text({.variable = keys}), expected) << keys;
}

}  // namespace value_words_test
}  // namespace takt::model
