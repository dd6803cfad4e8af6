// The requests that writes become, and the values that they show.
#include <gtest/gtest.h>

#include "writing.hpp"

namespace takt::poll {
namespace writing_test {

using namespace test;
using value::CommandResult;
using value::Value;

TEST(Writing, EveryFunctionWritesItsOwnKindOfRequest) {
    struct Case {
        Item item;
        Value value;
        const char* pdu;
    };
    const Case kCases[] = {
        {boolean("v", 1, 3).read(1).write(0x05), true, "05 00 13 FF 00"},
        {boolean("v", 1, 3).read(1).write(0x05), false, "05 00 13 00 00"},
        {boolean("v", 1, 3).read(1).write(0x0F), true, "0F 00 13 00 01 01 01"},
        {int16("v", 4).read(3).write(0x06), number(-2), "06 00 04 FF FE"},
        {int16("v", 4).read(3).write(0x10), number(258), "10 00 04 00 01 02 01 02"},
        {real("v", 4).read(3).write(0x10), 1.0, "10 00 04 00 02 04 00 00 3F 80"},
    };
    for (const auto& c : kCases) {
        Bench bench(project({device(1, {c.item})}));
        bench.run_until(50ms);
        ASSERT_TRUE(bench.write(1, "v", c.value));
        bench.run_until(99ms);
        const auto sent = writes(bench);
        ASSERT_EQ(sent.size(), 1U) << c.pdu;
        EXPECT_EQ(sent[0].bytes.substr(3, sent[0].bytes.size() - 9), c.pdu);
        ASSERT_EQ(bench.outcomes.size(), 1U);
        EXPECT_EQ(bench.outcomes[0].result, CommandResult::done);
        bench.run_until(150ms);
        EXPECT_TRUE(value::same(bench.slot("v").value, c.value)) << c.pdu;
    }
}

TEST(Writing, ScaledValuesGoBackExactlyAndRoundingIsSaid) {
    auto scaled = int16("v", 0).read(3).write(0x06);
    scaled.scale = 0.1;
    scaled.offset = -40;
    Bench bench(project({device(1, {scaled})}));
    bench.run_until(50ms);
    EXPECT_FALSE(bench.write(1, "v", 25.3).value());
    bench.run_until(90ms);
    EXPECT_EQ(bench.players[1].registers[0], 653);
    EXPECT_TRUE(bench.write(2, "v", 25.34).value());
    bench.run_until(150ms);
    EXPECT_EQ(bench.slot("v").value, Value(25.3));
    ASSERT_EQ(bench.outcomes.size(), 2U);
    EXPECT_FALSE(bench.outcomes[0].rounded);
    EXPECT_TRUE(bench.outcomes[1].rounded);
    EXPECT_EQ(bench.write(3, "v", 4000.0).error().code, Code::overflow);
}

TEST(Writing, WhatCannotBeWrittenIsRefusedAtOnce) {
    auto unused = int16("unused", 9).read(3).write(0x06);
    unused.used = false;
    Bench bench(project({device(1, {int16("v", 0).read(3).write(0x06), int16("input", 4).read(4), unused})}));
    EXPECT_EQ(bench.write(1, "v", number(40000)).error().code, Code::overflow);
    EXPECT_EQ(bench.write(1, "v", std::string("x")).error().code, Code::unsupported);
    EXPECT_EQ(bench.write(1, "input", number(1)).error().code, Code::not_writable);
    EXPECT_EQ(bench.set("input", number(1)).error().code, Code::not_writable);
    EXPECT_EQ(bench.write(1, "unused", number(1)).error().code, Code::not_writable);
    EXPECT_TRUE(bench.outcomes.empty());
}

TEST(Writing, WhatCannotBeReadShowsWhatWasWritten) {
    Bench bench(project({device(1, {int16("v", 0).write(0x06)})}));
    ASSERT_TRUE(bench.write(1, "v", number(7)));
    bench.run_until(50ms);
    EXPECT_EQ(bench.slot("v").value, number(7));
    EXPECT_EQ(bench.slot("v").quality, value::Quality::good);
}

TEST(Writing, ALocalIsWrittenAtOnce) {
    Bench bench(project({device(1, {int16("v", 0).read(3)})}, {local("go")}));
    ASSERT_TRUE(bench.write(5, "go", true));
    bench.run_until(1ms);
    ASSERT_EQ(bench.outcomes.size(), 1U);
    EXPECT_EQ(bench.outcomes[0].result, CommandResult::done);
    EXPECT_EQ(bench.slot("go").value, Value(true));
    EXPECT_EQ(bench.write(6, "go", number(2)).error().code, Code::overflow);
}

}  // namespace writing_test
}  // namespace takt::poll
