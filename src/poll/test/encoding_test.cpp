// How often values and reads are encoded. CMakeLists.txt lets the linker send the calls of value::encode()
// and wire::prepare() here.
#include <gtest/gtest.h>

#include "bench.hpp"
#include "takt/value/codec.hpp"

// clang-format off
#define TAKT_ENCODE_SYMBOL                                         \
    "_ZN4takt5value6encodeERKNS0_6LayoutERKSt7variantIJSt9monostate" \
    "blmdNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEEEE"
#define TAKT_PREPARE_SYMBOL "_ZN4takt4wire7prepareERKNS0_11ReadRequestE"
// clang-format on

namespace takt::poll::encoding_test {

using namespace test;
using value::CommandResult;
using value::Value;

std::size_t encodings = 0;
std::size_t preparations = 0;

Result<value::Encoded> really_encode(const value::Layout& layout,
                                     const Value& value) __asm__("__real_" TAKT_ENCODE_SYMBOL);
Result<value::Encoded> count_encoding(const value::Layout& layout,
                                      const Value& value) __asm__("__wrap_" TAKT_ENCODE_SYMBOL);
Result<value::Encoded> count_encoding(const value::Layout& layout, const Value& value) {
    ++encodings;
    return really_encode(layout, value);
}

Result<wire::PreparedRead> really_prepare(const wire::ReadRequest& read) __asm__(
    "__real_" TAKT_PREPARE_SYMBOL);
Result<wire::PreparedRead> count_preparation(const wire::ReadRequest& read) __asm__(
    "__wrap_" TAKT_PREPARE_SYMBOL);
Result<wire::PreparedRead> count_preparation(const wire::ReadRequest& read) {
    ++preparations;
    return really_prepare(read);
}

TEST(Encoding, ACommandIsEncodedOnceHoweverItIsWritten) {
    struct Case {
        const char* what;
        Item item;
        Value value;
        bool fc22 = false;
    };
    const Case kCases[] = {
        {"alone", real("v", 0).read(3).write(0x10), 1.5},
        {"alone, a coil", boolean("v", 1, 3).read(1).write(0x05), true},
        {"with its group", real("v", 0).read(3).write(0x10).on_change(), 1.5},
        {"by a mask", boolean("v", 1, 3).read(3).write(0x06), true, true},
        {"by read-modify-write", boolean("v", 1, 3).read(3).write(0x06), true},
        {"a group by a mask", boolean("v", 1, 3).read(3).write(0x06).on_change(), true, true},
        {"a group by read-modify-write", boolean("v", 1, 3).read(3).write(0x06).on_change(), true},
    };
    for (const auto& c : kCases) {
        auto described = device(1, {c.item.verified().repeatable()});
        described.fc22 = c.fc22;
        described.read_modify_write = true;
        described.attempts = 3;
        Bench bench(project({described}));
        bench.run_until(50ms);
        int writes = 0;
        bench.players[1].silent_to = [&](const wire::Request& request) {
            return !std::holds_alternative<wire::ReadRequest>(request) && ++writes == 1;
        };
        encodings = 0;
        ASSERT_TRUE(bench.write(1, "v", c.value)) << c.what;
        bench.run_until(2s);
        ASSERT_EQ(bench.outcomes.size(), 1U) << c.what;
        EXPECT_EQ(bench.outcomes[0].result, CommandResult::done) << c.what;
        EXPECT_EQ(writes, 2) << c.what << ": one attempt was not answered";
        EXPECT_TRUE(value::same(bench.slot("v").value, c.value)) << c.what;
        EXPECT_EQ(encodings, 1U) << c.what;
    }
}

TEST(Encoding, AGroupEncodesOnlyMembersThatWereNotSet) {
    Bench bench(project({device(
        1, {int16("a", 0).read(3).write(0x10).on_change(), int16("b", 1).read(3).write(0x10).on_change(),
            int16("c", 2).read(3).write(0x10).on_change()})}));
    bench.players[1].registers[2] = 7;
    bench.run_until(50ms);
    encodings = 0;
    ASSERT_TRUE(bench.set("a", std::int64_t{1}));
    ASSERT_TRUE(bench.set("b", std::int64_t{2}));
    EXPECT_EQ(encodings, 2U);
    bench.news();
    bench.run_until(90ms);
    const auto sent = bench.news();
    ASSERT_FALSE(sent.empty());
    EXPECT_NE(sent[0].bytes.find("10 00 00 00 03 06 00 01 00 02 00 07"), std::string::npos) << sent[0].bytes;
    EXPECT_EQ(encodings, 3U) << "c, as it was read";
    ASSERT_TRUE(bench.set("b", std::int64_t{3}));
    bench.run_until(190ms);
    EXPECT_EQ(encodings, 5U) << "b, which is new, and c";
}

// A command that was not executed restores the value wanted before it.
TEST(Encoding, ARestoredValueIsWrittenAsItWasSet) {
    auto described =
        device(1, {int16("a", 0).write(0x10).on_change(), int16("b", 1).write(0x10).on_change()});
    Bench bench(project({described}));
    ASSERT_TRUE(bench.set("a", std::int64_t{1}));
    ASSERT_TRUE(bench.set("b", std::int64_t{2}));
    bench.run_until(50ms);
    bench.players[1].exception = std::uint8_t{2};
    ASSERT_TRUE(bench.write(1, "a", std::int64_t{9}));
    bench.run_until(150ms);
    ASSERT_EQ(bench.outcomes.size(), 1U);
    EXPECT_EQ(bench.outcomes[0].result, CommandResult::refused);
    EXPECT_EQ(bench.slot("a").wanted, Value(std::int64_t{1}));
    bench.players[1].exception.reset();
    bench.news();
    ASSERT_TRUE(bench.set("b", std::int64_t{3}));
    bench.run_until(250ms);
    const auto sent = bench.news();
    ASSERT_FALSE(sent.empty());
    EXPECT_NE(sent[0].bytes.find("10 00 00 00 02 04 00 01 00 03"), std::string::npos) << sent[0].bytes;
}

TEST(Encoding, AReadIsEncodedWhenItsJobIsMade) {
    preparations = 0;
    auto described =
        device(1, {int16("a", 0).read(3), int16("b", 40).read(4), real("c", 60).read(3).every(1s)});
    described.registers_per_request = 4;
    Bench bench(project({described}));
    EXPECT_EQ(preparations, 3U);
    bench.run_until(5s);
    EXPECT_GT(bench.news().size(), 100U);
    EXPECT_EQ(preparations, 3U);
}

TEST(Encoding, AVerificationIsEncodedWithItsWrite) {
    Bench bench(project({device(1, {int16("group", 0).write(0x10).on_change().verified(),
                                    int16("alone", 9).write(0x06).verified()})}));
    bench.run_until(50ms);
    preparations = 0;
    for (value::CommandId id = 1; id <= 3; ++id) {
        ASSERT_TRUE(bench.write(2 * id, "group", static_cast<std::int64_t>(id)));
        ASSERT_TRUE(bench.write(2 * id + 1, "alone", static_cast<std::int64_t>(id)));
        bench.run_until(id * 100ms);
    }
    EXPECT_EQ(bench.outcomes.size(), 6U);
    EXPECT_EQ(preparations, 3U) << "one for each command that is written alone";
}

}  // namespace takt::poll::encoding_test
