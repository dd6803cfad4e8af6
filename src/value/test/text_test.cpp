#include "takt/value/text.hpp"

#include <gtest/gtest.h>

namespace takt::value {
namespace text_test {

TEST(Text, ReadsValuesOfEachType) {
    struct Case {
        DataType type;
        bool scaled;
        const char* text;
        Value value;
    };
    const Case kCases[] = {
        {DataType::boolean, false, "true", true},
        {DataType::boolean, false, "0", false},
        {DataType::int16, false, "-32768", std::int64_t{-32768}},
        {DataType::int16, false, "-0x10", std::int64_t{-16}},
        {DataType::uint16, false, "0x10", std::uint64_t{16}},
        {DataType::uint64, false, "18446744073709551615", ~std::uint64_t{0}},
        {DataType::int64, false, "-9223372036854775808", std::numeric_limits<std::int64_t>::min()},
        {DataType::int16, true, "1.25", 1.25},
        {DataType::float64, false, "1e-3", 0.001},
        {DataType::float32, false, "0.1", double{0.1F}},
        {DataType::string, false, " a b ", std::string(" a b ")},
    };
    for (const auto& c : kCases) {
        const auto value = parse(c.type, c.scaled, c.text);
        ASSERT_TRUE(value) << c.text;
        EXPECT_TRUE(same(*value, c.value)) << c.text;
    }
}

TEST(Text, RefusesWhatIsNoValueOfTheType) {
    struct Case {
        DataType type;
        std::string text;
        Code code;
        std::string subject;
    };
    const Case cases[] = {
        {DataType::boolean, "yes", Code::syntax, "yes → true, false, 1, 0"},
        {DataType::int16, "", Code::syntax, " → -32768..32767"},
        {DataType::int16, "010", Code::syntax, "010 → -32768..32767"},
        {DataType::int16, "1.0", Code::syntax, "1.0 → -32768..32767"},
        {DataType::int16, "0x", Code::syntax, "0x → -32768..32767"},
        {DataType::int16, " 1", Code::syntax, " 1 → -32768..32767"},
        {DataType::int16, "32768", Code::overflow, "32768 → -32768..32767"},
        {DataType::uint16, "-1", Code::overflow, "-1 → 0..65535"},
        {DataType::int32, "x", Code::syntax, "x → -2147483648..2147483647"},
        {DataType::float32, "1e39", Code::overflow, "1e39 → 1.5, -2e3, 16"},
        {DataType::float64, "1,5", Code::syntax, "1,5 → 1.5, -2e3, 16"},
        {DataType::float64, "", Code::syntax, " → 1.5, -2e3, 16"},
        {DataType::int64, "9223372036854775808", Code::overflow,
         "9223372036854775808 → -9223372036854775808..9223372036854775807"},
        {DataType::uint64, "18446744073709551616", Code::overflow,
         "18446744073709551616 → 0..18446744073709551615"},
        {DataType::uint16, std::string(150, 'x'), Code::syntax, std::string(104, 'x') + "… → 0..65535"},
    };
    for (const auto& c : cases) {
        const auto value = parse(c.type, false, c.text);
        ASSERT_FALSE(value) << c.text;
        EXPECT_EQ(value.error().code, c.code) << c.text;
        EXPECT_EQ(value.error().subject.view(), c.subject);
    }
    EXPECT_EQ(parse(DataType::int16, true, "x").error().subject.view(), "x → 1.5, -2e3, 16") << "scaled";
}

TEST(Text, WhatIsAllowedFitsBesideAnyText) {
    std::string text;
    for (int i = 0; i < 200; ++i) {
        const auto subject = beside_allowed(text, "yes");
        EXPECT_LE(subject.size(), 120U);
        EXPECT_TRUE(subject.ends_with(" → yes")) << subject;
        EXPECT_EQ((subject.size() - std::string_view(" → yes").size()) % 2, text.size() > 109 ? 1U : 0U)
            << "no half of a letter: " << subject;
        text += "ж";
    }
}

TEST(Text, ShowsTheShortestForm) {
    EXPECT_EQ(format(DataType::float32, false, double{0.1F}), "0.1");
    EXPECT_EQ(format(DataType::float64, false, 0.1), "0.1");
    EXPECT_EQ(format(DataType::float64, false, 3.0), "3");
    EXPECT_EQ(format(DataType::uint16, true, 1.2), "1.2");
    EXPECT_EQ(format(DataType::boolean, false, true), "true");
    EXPECT_EQ(format(DataType::int16, false, Value{}), "");
}

}  // namespace text_test
}  // namespace takt::value
