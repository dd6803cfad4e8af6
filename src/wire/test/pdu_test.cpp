#include "takt/wire/pdu.hpp"

#include <gtest/gtest.h>

#include "bytes.hpp"

namespace takt::wire {
namespace {

TEST(Pdu, GoldenRead) {
    const ReadRequest request{Function::read_holding_registers, {0x006B}, 3};
    EXPECT_EQ(to_hex(encode(Request(request))->span()), "03 00 6B 00 03");
    const auto response = decode_response(Request(request), from_hex("03 06 022B 0064 007F"));
    EXPECT_EQ(std::get<ReadRegistersResponse>(*response).values, (Registers{555, 100, 127}));
}

}  // namespace
}  // namespace takt::wire
