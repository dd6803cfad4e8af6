// Why a connection must be made again: the bytes and the field that are wrong.
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "rig.hpp"
#include "takt/bus/transaction_engine.hpp"

namespace takt::bus {
namespace rejection_test {

using namespace test;

LineConfig tcp_line() {
    return {.framing = wire::Framing::tcp, .in_flight = 3};
}

struct Rejected {
    std::string_view name;
    std::vector<std::string> received;  // after the request of transaction 1
    HeaderFault fault = HeaderFault::unknown;
    std::string_view bytes;
};

TEST(Rejection, HasTheBytesAndTheFieldOfAWrongHeader) {
    using enum HeaderFault;
    const Rejected cases[] = {
        {"protocol", {"0001 0100 0005 11 03 02 AAAA"}, protocol, "0001 0100 0005 11 03"},
        {"protocol in parts", {"00", "01 00", "01 0005 11"}, protocol, "0001 0001 0005 11"},
        {"no Modbus", {"53 53 48 2D 32 2E 30 2D 4F"}, protocol, "53 53 48 2D 32 2E 30 2D"},
        {"length 1", {"0001 0000 0001 11"}, length, "0001 0000 0001 11"},
        {"length 255", {"0001 0000", "00FF 11 03 02 AAAA"}, length, "0001 0000 00FF 11 03"},
        {"after a good frame",
         {"0001 0000 0005 11 03 02 AAAA 0002 1000 0005 11 03"},
         protocol,
         "0002 1000 0005 11 03"},
        {"one too little",
         {"0001 0000 0004 11 03 02 AAAA 0002 0000 0005 11 03 02 BBBB"},
         off_by_one,
         "0001 0000 0004 11 03"},
        {"one too little of an exception", {"0001 0000 0002 11 83 02"}, off_by_one, "0001 0000 0002 11 83"},
        {"one too much, with that byte",
         {"0001 0000 0006 11 03 02 AAAA 00"},
         off_by_one,
         "0001 0000 0006 11 03"},
    };
    for (const auto& [name, received, fault, bytes] : cases) {
        Rig rig(tcp_line());
        rig.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01"));
        rig.run_until(at(1ms));
        EXPECT_FALSE(rig.engine.rejection()) << name;
        for (const auto& part : received) rig.receive(at(2ms), part);
        EXPECT_TRUE(rig.engine.must_reconnect()) << name;
        rig.engine.on_link(at(4ms), false);
        const auto why = rig.engine.rejection();
        ASSERT_TRUE(why) << name;
        EXPECT_EQ(why->code, Code::not_modbus);
        std::uint64_t number = 0;
        for (const auto byte : hex(bytes)) number = number << 8U | byte;
        EXPECT_EQ(static_cast<std::uint64_t>(why->numbers[0]), number) << name;
        EXPECT_EQ(why->numbers[1], static_cast<std::int64_t>(hex(bytes).size())) << name;
        EXPECT_EQ(why->numbers[2], static_cast<std::int64_t>(fault)) << name;
        rig.engine.on_link(at(5ms), true);
        EXPECT_FALSE(rig.engine.rejection()) << name;
    }
}

TEST(Rejection, NamesALengthWhoseLastByteIsMissing) {
    Rig rig(tcp_line());
    rig.submit(at(0ms), transaction(1, 17, "03 00 6B 00 01", 50ms));
    rig.run_until(at(1ms));
    rig.receive(at(2ms), "0001 0000 0004 11 83 02");
    rig.run_until(at(60ms));
    EXPECT_TRUE(rig.engine.must_reconnect());
    const auto why = rig.engine.rejection();
    ASSERT_TRUE(why);
    EXPECT_EQ(why->numbers[0], 0x0001'0000'0004'1183);
    EXPECT_EQ(why->numbers[1], 8);
    EXPECT_EQ(why->numbers[2], static_cast<std::int64_t>(HeaderFault::off_by_one));
}

}  // namespace rejection_test
}  // namespace takt::bus
