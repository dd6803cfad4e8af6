#include "writes/single_write.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll::test {
namespace single_write_test {

using value::Value;

std::string pdu(const wire::Request& request) {
    return hex(wire::encode(request).value().span());
}

TEST(SingleWrite, EachKindOfVariableHasItsRequest) {
    struct Case {
        const char* what;
        Item item;
        Value value;
        bool fc22;
        bool modifies;
        const char* pdu;  // the first
    };
    const Case kCases[] = {
        {"coil", boolean("v", 1, 3).read(1).write(0x05), true, false, false, "05 00 13 FF 00"},
        {"register", int16("v", 4).read(3).write(0x06), std::int64_t{-2}, false, false, "06 00 04 FF FE"},
        {"float", real("v", 4).read(3).write(0x10), 1.0, false, false, "10 00 04 00 02 04 00 00 3F 80"},
        {"bit by mask", boolean("v", 1, 3).read(3).write(0x06), true, true, false, "16 00 01 FF F7 00 08"},
        {"bit by modify", boolean("v", 1, 3).read(3).write(0x06), true, false, true, "03 00 01 00 01"},
    };
    for (const auto& c : kCases) {
        SCOPED_TRACE(c.what);
        auto described = device(1, {c.item});
        described.fc22 = c.fc22;
        described.read_modify_write = true;
        const auto write = single_write_of(described, c.item, as_written(c.item, c.value).value());
        ASSERT_TRUE(write);
        EXPECT_EQ(hex(write->request.pdu()), c.pdu);
        EXPECT_EQ(write->modifies, c.modifies);
        EXPECT_FALSE(write->verify);
    }
}

TEST(SingleWrite, ABitIsPutIntoTheRegisterAsRead) {
    const auto item = boolean("v", 1, 3).read(3).write(0x06);
    auto described = device(1, {item});
    described.read_modify_write = true;
    for (const bool on : {false, true}) {
        const auto write = single_write_of(described, item, as_written(item, Value(on)).value());
        ASSERT_TRUE(write);
        EXPECT_EQ(pdu(second_step(*write, item, 0x8001)), on ? "06 00 01 80 09" : "06 00 01 80 01");
        EXPECT_EQ(pdu(second_step(*write, item, 0x8009)), on ? "06 00 01 80 09" : "06 00 01 80 01");
    }
}

TEST(SingleWrite, ADeviceWithoutEitherWayRefusesBits) {
    const auto item = boolean("v", 1, 3).read(3).write(0x06);
    const auto write = single_write_of(device(1, {item}), item, as_written(item, Value(true)).value());
    ASSERT_FALSE(write);
    EXPECT_EQ(write.error().code, Code::unsupported);
}

TEST(SingleWrite, AVerifiedVariableIsReadBack) {
    const auto item = int16("v", 4).read(3).write(0x06).verified();
    const auto write =
        single_write_of(device(1, {item}), item, as_written(item, Value(std::int64_t{1})).value());
    ASSERT_TRUE(write);
    ASSERT_TRUE(write->verify);
    EXPECT_EQ(write->verify->request.start(), DataAddress{4});
}

}  // namespace single_write_test
}  // namespace takt::poll::test
