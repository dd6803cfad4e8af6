#include "takt/bus/number_list.hpp"

#include <gtest/gtest.h>

#include <string>

namespace takt::bus {
namespace number_list_test {

using Numbers = std::vector<std::uint32_t>;
using Parities = std::vector<wire::Parity>;
using wire::Parity;

TEST(NumberList, ReadsNumbersAndRangesInTheirOrder) {
    const struct {
        const char* text;
        Numbers numbers;
    } cases[] = {{"1-3,16,2", {1, 2, 3, 16}}, {"247", {247}}, {"16,1-3", {16, 1, 2, 3}}, {"5-5", {5}}};
    for (const auto& [text, numbers] : cases) EXPECT_EQ(parse_numbers(text, 1, 247), numbers) << text;
}

TEST(NumberList, RejectsTextThatIsNoListWithThePart) {
    const struct {
        const char* text;
        const char* part;
    } cases[] = {{"", ""},       {",", ""},    {"1,", ""},     {"3-1", "3-1"},
                 {"-3", "-3"},   {"1-", "1-"}, {"x", "x"},     {"0x10", "0x10"},
                 {"1 2", "1 2"}, {"1,,2", ""}, {"1,a,b", "a"}, {"99999999999", "99999999999"}};
    for (const auto& [text, part] : cases)
        EXPECT_EQ(parse_numbers(text, 1, 247).error(), fail(Code::syntax, part).error()) << text;
}

TEST(NumberList, RefusesNumbersOutsideTheRangeAndTooMany) {
    EXPECT_EQ(parse_numbers("1,300", 1, 247).error(), fail(Code::out_of_range, 300, 1, 247).error());
    EXPECT_EQ(parse_numbers("0-5", 1, 247).error(), fail(Code::out_of_range, 0, 1, 247).error());
    EXPECT_EQ(parse_numbers("50-4000000", 50, 4'000'000).error().code, Code::too_long);
    EXPECT_EQ(parse_numbers("1-4096", 1, 5000).value().size(), kMaxListed);
    EXPECT_EQ(parse_numbers("1-4097", 1, 5000).error().code, Code::too_long);
}

TEST(NumberList, ALongPartIsShortenedInTheError) {
    const auto read = parse_numbers(std::string(5000, 'x'), 1, 247);
    EXPECT_LT(read.error().subject.view().size(), 80U);
}

TEST(NumberList, ReadsParities) {
    EXPECT_EQ(parse_parities("none"), Parities{Parity::none});
    EXPECT_EQ(parse_parities("odd,even,odd"), (Parities{Parity::odd, Parity::even}));
    for (const char* text : {"", "None", "even,", "even odd"})
        EXPECT_EQ(parse_parities(text).error().code, Code::syntax) << text;
    EXPECT_EQ(parse_parities("none,mark").error().subject.view(), "mark");
}

}  // namespace number_list_test
}  // namespace takt::bus
