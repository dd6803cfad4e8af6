#include "pcapng.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

namespace takt::web {
namespace {

struct Block {
    std::uint32_t type = 0;
    std::string body;
};

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
    std::uint32_t number = 0;
    std::memcpy(&number, bytes.data() + at, sizeof number);
    return number;
}

std::vector<Block> blocks_of(std::string_view bytes) {
    std::vector<Block> blocks;
    while (!bytes.empty()) {
        const auto length = number_at(bytes, 4);
        EXPECT_EQ(length % 4, 0u);
        EXPECT_EQ(number_at(bytes, length - 4), length);
        blocks.push_back({number_at(bytes, 0), std::string(bytes.substr(8, length - 12))});
        bytes.remove_prefix(length);
    }
    return blocks;
}

/// The IP packet of an enhanced packet block.
std::string packet_of(const Block& block) {
    return block.body.substr(20, number_at(block.body, 12));
}

TEST(Pcapng, BeginsWithSectionAndInterface) {
    const auto blocks = blocks_of(PcapngWriter().bytes());
    ASSERT_EQ(blocks.size(), 2u);
    EXPECT_EQ(blocks[0].type, 0x0A0D0D0Au);
    EXPECT_EQ(number_at(blocks[0].body, 0), 0x1A2B3C4Du);
    EXPECT_EQ(blocks[1].type, 1u);
    EXPECT_EQ(number_at(blocks[1].body, 0), 101u);  // raw IP
}

TEST(Pcapng, WritesFramesAsModbusTcp) {
    PcapngWriter writer;
    const std::vector<std::uint8_t> request{0x03, 0x00, 0x00, 0x00, 0x01};
    const std::vector<std::uint8_t> response{0x03, 0x02, 0x12, 0x34};
    writer.add({.wall_ns = 0x100000002, .request = true, .unit = 16, .pdu = request, .comment = "x"});
    writer.add({.wall_ns = 0x100000003, .request = false, .unit = 16, .pdu = response});
    const auto blocks = blocks_of(writer.bytes());
    ASSERT_EQ(blocks.size(), 4u);
    EXPECT_EQ(blocks[2].type, 6u);
    EXPECT_EQ(number_at(blocks[2].body, 4), 1u);
    EXPECT_EQ(number_at(blocks[2].body, 8), 2u);
    const auto sent = packet_of(blocks[2]);
    const auto received = packet_of(blocks[3]);
    EXPECT_EQ(sent.size(), 20u + 20 + 7 + 5);
    EXPECT_EQ(sent.substr(40), std::string("\x00\x01\x00\x00\x00\x06\x10\x03\x00\x00\x00\x01", 12));
    EXPECT_EQ(received.substr(40), std::string("\x00\x01\x00\x00\x00\x05\x10\x03\x02\x12\x34", 11));
    EXPECT_EQ(sent.substr(12, 4), received.substr(16, 4));
    // The response acknowledges the request.
    EXPECT_EQ(received.substr(28, 4), std::string("\x00\x00\x00\x0D", 4));
}

TEST(Pcapng, KeepsLinesAndUnitsApart) {
    PcapngWriter writer;
    const std::vector<std::uint8_t> pdu{0x07};
    writer.add({.line = 0, .request = true, .unit = 1, .pdu = pdu});
    writer.add({.line = 0, .request = true, .unit = 2, .pdu = pdu});
    writer.add({.line = 0, .request = false, .unit = 1, .pdu = pdu});
    writer.add({.line = 1, .request = true, .unit = 1, .pdu = pdu});
    writer.add({.line = 1, .request = false, .unit = 9, .pdu = pdu});
    const auto blocks = blocks_of(writer.bytes());
    std::vector<int> identifiers;
    for (std::size_t i = 2; i < blocks.size(); ++i) identifiers.push_back(packet_of(blocks[i])[41]);
    EXPECT_EQ(identifiers, (std::vector<int>{1, 2, 1, 1, 2}));
    EXPECT_NE(packet_of(blocks[2]).substr(16, 4), packet_of(blocks[5]).substr(16, 4));
}

}  // namespace
}  // namespace takt::web
