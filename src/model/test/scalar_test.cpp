#include "takt/model/scalar.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>

namespace takt::model {
namespace scalar_test {

using namespace std::chrono_literals;

TEST(Scalar, Integers) {
    struct Case {
        std::string_view text;
        Scalar<std::int64_t> value;
    };
    constexpr auto no = [](ScalarError error) { return std::unexpected(error); };
    const Case cases[] = {
        {"0", 0},
        {"-0", 0},
        {"42", 42},
        {"-7", -7},
        {"0x10", 16},
        {"0XfF", 255},
        {"0x00ff", 255},
        {"-0x1", -1},
        {"9223372036854775807", std::numeric_limits<std::int64_t>::max()},
        {"-9223372036854775808", std::numeric_limits<std::int64_t>::min()},
        {"010", no(ScalarError::leading_zero)},
        {"-010", no(ScalarError::leading_zero)},
        {"00", no(ScalarError::leading_zero)},
        {"1.5", no(ScalarError::fraction)},
        {"1e3", no(ScalarError::fraction)},
        {"18446744073709551616", no(ScalarError::too_large)},
        {"99999999999999999999999", no(ScalarError::too_large)},
        {"0x10000000000000000", no(ScalarError::too_large)},
        {"", no(ScalarError::malformed)},
        {"-", no(ScalarError::malformed)},
        {"0x", no(ScalarError::malformed)},
        {"0x-1", no(ScalarError::malformed)},
        {"+5", no(ScalarError::malformed)},
        {"5 ", no(ScalarError::malformed)},
        {"1_000", no(ScalarError::malformed)},
        {"0b1", no(ScalarError::malformed)},
        {"ten", no(ScalarError::malformed)},
    };
    for (const auto& [text, value] : cases) {
        const auto parsed = parse_integer(text);
        if (value) {
            ASSERT_TRUE(parsed) << text;
            EXPECT_EQ(parsed->as_int64(), *value) << text;
        } else {
            ASSERT_FALSE(parsed) << text;
            EXPECT_EQ(parsed.error(), value.error()) << text;
        }
    }
    EXPECT_EQ(parse_integer("9223372036854775808")->as_int64(), std::nullopt);
    EXPECT_EQ(parse_integer("18446744073709551615")->magnitude, std::numeric_limits<std::uint64_t>::max());
}

TEST(Scalar, Durations) {
    struct Case {
        std::string_view text;
        Scalar<Duration> value;
    };
    constexpr auto no = [](ScalarError error) { return std::unexpected(error); };
    const Case cases[] = {
        {"0", 0ns},
        {"0ms", 0ns},
        {"100ms", 100ms},
        {"1s", 1s},
        {"1 s", 1s},
        {"500us", 500us},
        {"500µs", 500us},
        {"7ns", 7ns},
        {"2min", 2min},
        {"1h", 1h},
        {"2d", 48h},
        {"1.5s", 1500ms},
        {"0.25ms", 250us},
        {"0.000000001s", 1ns},
        {"100", no(ScalarError::no_unit)},
        {"0.0", no(ScalarError::no_unit)},
        {"010ms", no(ScalarError::leading_zero)},
        {"0.0000000001s", no(ScalarError::fraction)},
        {"0.05ns", no(ScalarError::fraction)},
        {"9999999999h", no(ScalarError::too_large)},
        {"99999999999999999999s", no(ScalarError::too_large)},
        {"-1s", no(ScalarError::malformed)},
        {"1.s", no(ScalarError::malformed)},
        {".5s", no(ScalarError::malformed)},
        {"1.2.3s", no(ScalarError::malformed)},
        {"ms", no(ScalarError::malformed)},
        {"", no(ScalarError::malformed)},
        {"5w", no(ScalarError::malformed)},
        {"5m", no(ScalarError::malformed)},
        {"0x10ms", no(ScalarError::malformed)},
    };
    for (const auto& [text, value] : cases) EXPECT_EQ(parse_duration(text), value) << text;
}

TEST(Scalar, NumbersAndBools) {
    EXPECT_EQ(parse_number("-1.5e3"), -1500.0);
    EXPECT_EQ(parse_number("0.1"), 0.1);
    EXPECT_EQ(parse_number("0"), 0.0);
    for (const auto* text : {"", "-", "0,1", "nan", "inf", ".5", "0x10", "1.5x", "+1", "- 1"})
        EXPECT_EQ(parse_number(text), std::unexpected(ScalarError::malformed)) << text;
    EXPECT_EQ(parse_number("1e999"), std::unexpected(ScalarError::too_large));
    EXPECT_EQ(parse_number("01.5"), std::unexpected(ScalarError::leading_zero));
    EXPECT_EQ(parse_bool("true"), true);
    EXPECT_EQ(parse_bool("FALSE"), false);
    for (const auto* text : {"yes", "no", "on", "off", "1", "0", "tRUE", ""})
        EXPECT_EQ(parse_bool(text), std::nullopt);
}

RC_GTEST_PROP(Scalar, DurationsComeBack, ()) {
    const Duration duration(*rc::gen::inRange<std::int64_t>(0, std::int64_t{1} << 62));
    RC_ASSERT(parse_duration(to_text(duration)).value() == duration);
}

RC_GTEST_PROP(Scalar, IntegersComeBack, ()) {
    const auto number = *rc::gen::arbitrary<std::int64_t>();
    RC_ASSERT(parse_integer(std::to_string(number))->as_int64() == number);
}

RC_GTEST_PROP(Scalar, NoTextDoesHarm, ()) {
    const auto text =
        *rc::gen::container<std::string>(rc::gen::elementOf(std::string("0123456789-+.xeEsmunhi ,")));
    (void)parse_integer(text);
    (void)parse_number(text);
    if (const auto duration = parse_duration(text)) RC_ASSERT(*duration >= Duration::zero());
}

}  // namespace scalar_test
}  // namespace takt::model
