#include "takt/discover/number_list.hpp"

#include <gtest/gtest.h>

#include <string>

namespace takt::discover {
namespace {

using Numbers = std::vector<std::uint32_t>;
using Parities = std::vector<wire::Parity>;
using wire::Parity;

TEST(NumberList, ReadsNumbersAndRangesInTheirOrder) {
    const struct {
        const char* text;
        Numbers numbers;
    } cases[] = {{"1-3,16,2", {1, 2, 3, 16}}, {"247", {247}}, {"16,1-3", {16, 1, 2, 3}}, {"5-5", {5}}};
    for (const auto& [text, numbers] : cases)
        EXPECT_EQ(parse_numbers("--units", text, 1, 247), numbers) << text;
}

TEST(NumberList, RefusesWhatIsNoListWithTheOptionAndAnExample) {
    for (const char* text : {"", ",", "1,", "3-1", "-3", "1-", "x", "0x10", "1 2", "99999999999", "1,,2"}) {
        const auto read = parse_numbers("--units", text, 1, 247);
        ASSERT_FALSE(read) << text;
        EXPECT_EQ(read.error().code, Code::syntax) << text;
        const std::string subject(read.error().subject.view());
        EXPECT_TRUE(subject.starts_with("--units ")) << subject;
        EXPECT_TRUE(subject.ends_with(" → 1-10,16")) << subject;
    }
    EXPECT_TRUE(parse_numbers("--bauds", "x", 1, 9).error().subject.view().ends_with("9600,19200"));
    EXPECT_TRUE(parse_numbers("--stop-bits", "x", 1, 2).error().subject.view().ends_with("1,2"));
}

TEST(NumberList, RefusesNumbersOutsideTheRangeAndTooMany) {
    EXPECT_EQ(parse_numbers("--units", "1,300", 1, 247).error(),
              fail(Code::out_of_range, "--units", 300, 1, 247).error());
    EXPECT_EQ(parse_numbers("--units", "0-5", 1, 247).error(),
              fail(Code::out_of_range, "--units", 0, 1, 247).error());
    EXPECT_EQ(parse_numbers("--bauds", "50-4000000", 50, 4'000'000).error().code, Code::too_long);
    EXPECT_EQ(parse_numbers("--bauds", "1-4096", 1, 5000).value().size(), kMaxListed);
    EXPECT_EQ(parse_numbers("--bauds", "1-4097", 1, 5000).error().code, Code::too_long);
}

TEST(NumberList, ALongPartIsShortenedInTheError) {
    const auto read = parse_numbers("--units", std::string(5000, 'x'), 1, 247);
    EXPECT_LT(read.error().subject.view().size(), 80U);
}

TEST(NumberList, ReadsParities) {
    EXPECT_EQ(parse_parities("none"), Parities{Parity::none});
    EXPECT_EQ(parse_parities("odd,even,odd"), (Parities{Parity::odd, Parity::even}));
    for (const char* text : {"", "None", "even,", "even odd"})
        EXPECT_EQ(parse_parities(text).error().code, Code::syntax) << text;
}

}  // namespace
}  // namespace takt::discover
