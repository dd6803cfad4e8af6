#include "options/blank_options.hpp"

#include <gtest/gtest.h>

namespace takt::app {
namespace blank_options_test {

TEST(BlankOptions, AnItemRangeHasAnAreaAndAddresses) {
    const auto range = parse_item_range("holding:5..0x10");
    ASSERT_TRUE(range);
    EXPECT_EQ(range->area, wire::Area::holding_register);
    EXPECT_EQ(range->addresses.first, 5);
    EXPECT_EQ(range->addresses.last, 16);
    const auto one = parse_item_range("coils:7");
    ASSERT_TRUE(one);
    EXPECT_EQ(one->addresses.first, one->addresses.last);
    for (const auto* const text : {"", "holding", "holding:", "other:1", "holding:9..5", "holding:65536",
                                   "holding:-1", "holding:1..2..3", "holding:0x-1"})
        EXPECT_FALSE(parse_item_range(text)) << text;
}

TEST(BlankOptions, ValueLimitsAreAllSignedOrAllUnsigned) {
    const auto limit = parse_value_limits("holding:0..9=-5..100");
    ASSERT_TRUE(limit);
    EXPECT_TRUE(parse_value_limits("holding:0=0..65535"));
    EXPECT_TRUE(parse_value_limits("holding:0=-32768..32767"));
    for (const auto* const text : {"holding:0=-1..65535", "holding:0", "input:0=1..2", "holding:0=5..1"})
        EXPECT_FALSE(parse_value_limits(text)) << text;
}

TEST(BlankOptions, FilesQueuesAndObjectsHaveTheirLimits) {
    EXPECT_TRUE(parse_file_records("4:100"));
    EXPECT_FALSE(parse_file_records("0:100"));
    EXPECT_FALSE(parse_file_records("4:10001"));
    const auto queue = parse_fifo("1246:440,0x1284");
    ASSERT_TRUE(queue);
    EXPECT_EQ(queue->values, (std::vector<std::uint16_t>{440, 4740}));
    EXPECT_TRUE(parse_fifo("1246:"));
    std::string full = "1:0";
    for (int i = 1; i < 31; ++i) full += ",0";
    EXPECT_TRUE(parse_fifo(full));
    EXPECT_FALSE(parse_fifo(full + ",0"));
    const auto object = parse_object("0x80=a=b");
    ASSERT_TRUE(object);
    EXPECT_EQ(object->id, 0x80);
    EXPECT_EQ(object->text, "a=b");
    EXPECT_FALSE(parse_object("256=a"));
    EXPECT_FALSE(parse_object("0=" + std::string(245, 'x')));
}

}  // namespace blank_options_test
}  // namespace takt::app
