#include "writes/written_values.hpp"

#include <gtest/gtest.h>

#include <array>

#include "write_fixture.hpp"

namespace takt::poll::test {
namespace written_values_test {

using value::Value;

const auto kRead = int16("r", 0).read(3).write(0x06);

TEST(WrittenValues, OnlyVariablesThatWereAddedHaveThem) {
    WriteFixture made({int16("input", 0).read(4), kRead});
    EXPECT_FALSE(made.values.writable(0));
    EXPECT_TRUE(made.values.writable(1));
    EXPECT_FALSE(made.values.writable(2));
    made.values.note_read(0, number(1));
    made.values.note_read(2, number(1));
}

// Wanted, else read, else initial.
TEST(WrittenValues, TheNewestKindOfValueIsWritten) {
    WriteFixture made({kRead, int16("d", 1).write(0x06).defaults_to(9)});
    EXPECT_EQ(made.values.to_write(0), nullptr);
    ASSERT_NE(made.values.to_write(1), nullptr);
    EXPECT_EQ(*made.values.to_write(1), number(9));
    made.values.note_read(0, number(5));
    made.values.note_read(1, number(6));
    EXPECT_EQ(*made.values.to_write(0), number(5));
    EXPECT_EQ(*made.values.to_write(1), number(6));
    EXPECT_FALSE(made.values.was_set(0));
    made.values.want(0, made.written(0, number(7)));
    EXPECT_TRUE(made.values.was_set(0));
    EXPECT_EQ(*made.values.to_write(0), number(7));
    made.values.note_read(0, number(8));
    EXPECT_EQ(*made.values.to_write(0), number(7)) << "until another value is set";
}

TEST(WrittenValues, AnInitialValueThatDoesNotFitIsNone) {
    WriteFixture made({int16("v", 0).write(0x06).defaults_to(70000)});
    EXPECT_EQ(made.values.to_write(0), nullptr);
}

TEST(WrittenValues, EncodesWhatIsWritten) {
    auto scaled = int16("v", 0).read(3).write(0x06);
    scaled.scale = 0.1;
    WriteFixture made({scaled});
    made.values.want(0, made.written(0, 25.34));
    const auto wanted = made.values.encoded(0).value();
    EXPECT_EQ(wanted.value, Value(25.3));
    EXPECT_EQ(wanted.words[0], 253);
    made.values.restore(0, made.values.number(0), {});
    made.values.note_read(0, 12.5);
    EXPECT_EQ(made.values.encoded(0).value().words[0], 125);
}

TEST(WrittenValues, NumbersGrowOverTheLine) {
    WriteFixture made({kRead, kRead});
    EXPECT_EQ(made.values.number(0), 0U);
    EXPECT_EQ(made.values.want(0, made.written(0, number(1))), 1U);
    EXPECT_EQ(made.values.want(1, made.written(1, number(2))), 2U);
    EXPECT_EQ(made.values.number(0), 1U);
    EXPECT_EQ(made.values.last_number(), 2U);
}

TEST(WrittenValues, RestoresOnlyWhereNothingWasSetSince) {
    for (const bool set_since : {false, true}) {
        WriteFixture made({kRead});
        made.values.want(0, made.written(0, number(1)));
        const auto before = made.values.wanted(0);
        const auto want = made.values.want(0, made.written(0, number(2)));
        if (set_since) made.values.want(0, made.written(0, number(2)));
        made.values.restore(0, want, before);
        EXPECT_EQ(made.wanted(0), number(set_since ? 2 : 1));
        EXPECT_EQ(made.values.number(0), set_since ? 3U : 1U);
    }
}

// Others are never shown and never compared.
TEST(WrittenValues, KeepsWhatWasSentIfItIsShownOrVerified) {
    WriteFixture made({kRead, kRead.verified(), int16("w", 1).write(0x06)});
    for (const std::size_t v : {0U, 1U, 2U}) made.values.note_sent(v, number(4));
    EXPECT_TRUE(value::is_empty(made.values.sent(0)));
    EXPECT_EQ(made.values.sent(1), number(4));
    EXPECT_EQ(made.values.sent(2), number(4));
}

TEST(WrittenValues, ContinuesThoseOfAnotherLine) {
    WriteFixture old({int16("x", 9).read(3), kRead.verified()});
    old.values.want(1, old.written(1, number(3)));
    old.values.note_sent(1, number(3));
    old.values.note_read(1, number(2));
    WriteFixture made({kRead.verified(), kRead});
    made.values.continue_numbers(old.values);
    made.values.take_over(0, old.values, 1);
    made.values.take_over(1, old.values, 0);
    EXPECT_EQ(made.values.number(0), 1U);
    EXPECT_EQ(made.values.last_number(), 1U);
    EXPECT_EQ(made.values.sent(0), number(3));
    EXPECT_EQ(*made.values.to_write(0), number(2));
    EXPECT_EQ(made.values.to_write(1), nullptr);
}

}  // namespace written_values_test
}  // namespace takt::poll::test
