#include "sources/command_text.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "takt/model/text_template.hpp"

namespace takt::endpoint {
namespace command_text_test {

model::InstrumentCommand command(const char* request) {
    model::InstrumentCommand made{.name = "c"};
    made.request = *model::parse_template(request);
    return made;
}

std::string text(const model::InstrumentCommand& command, const value::Value& value) {
    const auto made = command_text(command, value);
    return made ? command_bytes(command, *made) : "-";
}

TEST(CommandText, Numbers) {
    struct Row {
        value::Value value;
        std::optional<std::uint8_t> decimals;
        std::uint8_t digits;
        const char* expected;
    };
    const Row rows[] = {
        {std::int64_t{-5}, {}, 1, "T-5\r"},
        {std::int64_t{-5}, {}, 3, "T-005\r"},
        {std::uint64_t{7}, 2, 1, "T7.00\r"},
        {true, {}, 1, "T1\r"},
        {12.5, {}, 1, "T12.5\r"},
        {12.5, 2, 4, "T0012.50\r"},
        {double{0.1F}, {}, 1, "T0.1\r"},
        {1.2, {}, 1, "T1.2\r"},
        {-0.001, 2, 1, "T0.00\r"},
        {-0.0, {}, 1, "T0\r"},
        {-2.5, 0, 1, "T-2\r"},
        {1e20, {}, 1, "T100000000000000000000\r"},
        {std::numeric_limits<std::int64_t>::min(), {}, 1, "T-9223372036854775808\r"},
        {std::numeric_limits<std::uint64_t>::max(), {}, 1, "T18446744073709551615\r"},
        {1e300, {}, 1, "-"},
        {std::nan(""), {}, 1, "-"},
        {std::numeric_limits<double>::infinity(), 2, 1, "-"},
        {std::string("5"), {}, 1, "-"},
        {value::Value{}, {}, 1, "-"},
    };
    for (const auto& [value, decimals, digits, expected] : rows) {
        auto made = command("T{value}\\r");
        made.format.decimals = decimals;
        made.format.digits = digits;
        EXPECT_EQ(text(made, value), expected);
    }
}

TEST(CommandText, HexadecimalNumbers) {
    auto made = command("A{value:hex};");
    EXPECT_EQ(text(made, std::int64_t{171}), "AAB;");
    EXPECT_EQ(text(made, 171.0), "AAB;");
    EXPECT_EQ(text(made, 171.5), "-");
    EXPECT_EQ(text(made, std::int64_t{-1}), "-");
    EXPECT_EQ(text(made, 1.9e19), "-");
    made.format.digits = 4;
    EXPECT_EQ(text(made, std::int64_t{171}), "A00AB;");
}

TEST(CommandText, TheRangeIsInclusive) {
    auto made = command("T{value}");
    made.format.least = -1.5;
    made.format.greatest = 10;
    EXPECT_EQ(text(made, -1.5), "T-1.5");
    EXPECT_EQ(text(made, std::uint64_t{10}), "T10");
    EXPECT_EQ(text(made, std::int64_t{-2}), "-");
    EXPECT_EQ(text(made, 10.001), "-");
    EXPECT_TRUE(value_text(made, 10.001)) << "a value that was read has no range";
}

TEST(CommandText, ATextCannotLeaveItsPosition) {
    const auto made = command("NAME {value:text}/\\r");
    EXPECT_EQ(text(made, std::string("Silo 1_a.b+c-d ")), "NAME Silo 1_a.b+c-d/\r");
    for (const char* const bad : {"", "   ", "a\rRESET", "a\nb", "a;b", "a\"b", "a'b", "a,b", "a:b", "a/b",
                                  "\x7F", "\xC2\x85", "a\tb", "{value}", "\\r"})
        EXPECT_EQ(text(made, std::string(bad)), "-") << bad;
    EXPECT_EQ(text(made, std::string("a\0b", 3)), "-");
    EXPECT_EQ(text(made, std::string(65, 'a')), "-");
    EXPECT_EQ(text(made, std::int64_t{5}), "-");
    EXPECT_EQ(text(command("N{value:text}x\\r"), std::string("ax")), "-") << "it ends the value";
}

RC_GTEST_PROP(CommandText, NoTextAddsALine, (const std::string& value)) {
    const auto made = command("N{value:text}\\r");
    const auto bytes = text(made, value);
    RC_ASSERT(bytes == "-" || std::ranges::all_of(bytes.substr(0, bytes.size() - 1),
                                                  [](char c) { return c >= ' ' && c <= '~' && c != ';'; }));
}

RC_GTEST_PROP(CommandText, ANumberIsReadBackAsTheSameText, (double number)) {
    const auto made = command("{value}");
    const auto sent = command_text(made, number);
    if (!sent) return;
    RC_ASSERT(value_text(made, value::Value(std::stod(*sent))) == *sent);
}

}  // namespace command_text_test
}  // namespace takt::endpoint
