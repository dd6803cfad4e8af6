#include "takt/value/text.hpp"

#include <gtest/gtest.h>

namespace takt::value {
namespace {

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
        const char* text;
        Code code;
    };
    constexpr Case kCases[] = {
        {DataType::boolean, "yes", Code::syntax},
        {DataType::int16, "", Code::syntax},
        {DataType::int16, "010", Code::syntax},
        {DataType::int16, "1.0", Code::syntax},
        {DataType::int16, "0x", Code::syntax},
        {DataType::int16, " 1", Code::syntax},
        {DataType::int16, "32768", Code::overflow},
        {DataType::uint16, "-1", Code::overflow},
        {DataType::float32, "1e39", Code::overflow},
        {DataType::float64, "1,5", Code::syntax},
        {DataType::float64, "", Code::syntax},
        {DataType::uint64, "18446744073709551616", Code::overflow},
    };
    for (const auto& c : kCases) {
        const auto value = parse(c.type, false, c.text);
        ASSERT_FALSE(value) << c.text;
        EXPECT_EQ(value.error().code, c.code) << c.text;
        EXPECT_EQ(value.error().subject.view(), c.text);
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

}  // namespace
}  // namespace takt::value
