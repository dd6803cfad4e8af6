#include "mqtt/packet_gate.hpp"

#include <gtest/gtest.h>

#include <string>

namespace takt::publish {
namespace packet_gate_test {

using namespace std::string_literals;

constexpr std::size_t kLimit = 200;

/// A packet with a length field of the least number of bytes.
std::string packet(int first, const std::string& body) {
    std::string bytes(1, static_cast<char>(first));
    std::size_t left = body.size();
    do {
        bytes += static_cast<char>((left & 0x7FU) | (left > 127 ? 0x80U : 0U));
        left >>= 7U;
    } while (left > 0);
    return bytes + body;
}

std::string publish(int qos, const std::string& topic, std::size_t payload,
                    const std::string& id = "\x12\x34") {
    return packet(0x30 | qos << 1U,
                  std::string{static_cast<char>(topic.size() >> 8U), static_cast<char>(topic.size())} +
                      topic + (qos > 0 ? id : "") + std::string(payload, 'x'));
}

struct Passed {
    std::string to_library;
    std::string to_broker;
    std::vector<std::string> dropped;
    std::string failure;
};

/// Passes bytes in parts of this length.
Passed pass(const std::string& bytes, std::size_t part) {
    PacketGate gate(kLimit);
    Passed passed;
    for (std::size_t at = 0; at < bytes.size(); at += part) {
        gate.from_broker(std::string_view(bytes).substr(at, part), passed.to_library);
        gate.to_broker({}, passed.to_broker);
        while (auto dropped = gate.next_dropped())
            passed.dropped.push_back(dropped->topic + " " + std::to_string(dropped->bytes));
    }
    if (gate.failure()) passed.failure = gate.failure()->text;
    return passed;
}

TEST(PacketGate, DropsWhatIsTooLargeAndAcknowledgesIt) {
    const std::string small = packet(0x20, "\0\0"s) + packet(0xD0, "") + publish(1, "a/b", 10);
    const std::string edge = publish(0, "edge", 191);  // 200 bytes
    ASSERT_EQ(edge.size(), kLimit);
    struct Row {
        std::string bytes;
        std::string acknowledged;
        std::vector<std::string> dropped;
    };
    const Row rows[] = {
        {"", "", {}},
        {publish(0, "edge", 192), "", {"edge 201"}},
        {publish(1, "t/one", 5000), "\x40\x02\x12\x34", {"t/one 5012"}},
        {publish(2, "t/two", 300, "\x01\x00"s), "\x50\x02\x01\x00"s, {"t/two 312"}},
        {publish(1, "a", 300) + publish(1, "b", 300, "\x56\x78"),
         "\x40\x02\x12\x34\x40\x02\x56\x78",
         {"a 308", "b 308"}},
        {publish(0, std::string(201, 'z'), 0), "", {std::string(200, 'z') + "… 206"}},
        {publish(0, std::string(199, 'z') + "\xC3\xA9", 0), "", {std::string(199, 'z') + "… 206"}},
        {publish(0, "#", 300), "", {"? 306"}},
    };
    for (const auto& row : rows)
        for (const std::size_t part : {1UL, 2UL, 3UL, 7UL, 4096UL, 1000000UL}) {
            const auto passed = pass(small + row.bytes + edge + row.bytes + small, part);
            EXPECT_EQ(passed.to_library, small + edge + small) << part;
            EXPECT_EQ(passed.to_broker, row.acknowledged + row.acknowledged) << part;
            auto twice = row.dropped;
            twice.insert(twice.end(), row.dropped.begin(), row.dropped.end());
            EXPECT_EQ(passed.dropped, twice) << part;
            EXPECT_EQ(passed.failure, "");
        }
}

TEST(PacketGate, AMessageWithoutAnEndIsReportedButNotAcknowledged) {
    const auto passed = pass("\x32\xFF\xFF\xFF\x7F" + "\0\4slow\x12\x34"s + std::string(5000, 'x'), 100);
    EXPECT_EQ(passed.dropped, std::vector{"slow 268435460"s});
    EXPECT_EQ(passed.to_broker, "");
    EXPECT_EQ(passed.to_library, "");
}

TEST(PacketGate, OtherPacketsThatAreTooLargeEndTheConnection) {
    struct Row {
        std::string bytes;
        std::string failure;
    };
    const Row rows[] = {
        {packet(0x90, std::string(300, 'x')), "a packet of type 9 with 303 bytes; allowed: 200"},
        {publish(3, "t", 300), "a packet of type 3 with 308 bytes; allowed: 200"},
        {publish(2, "t", 1), "PUBLISH with QoS 2; subscribed was QoS 1"},
        {publish(1, "t", 300, "\0\0"s), "PUBLISH without a topic or an identifier"},
        {packet(0x30, "\xFF\xFF" + std::string(300, 'x')), "PUBLISH without a topic or an identifier"},
        {"\x30\xFF\xFF\xFF\xFF\x01", "a packet whose length has more than four bytes"},
    };
    for (const auto& row : rows)
        for (const std::size_t part : {1UL, 4096UL}) {
            const auto passed = pass(row.bytes + packet(0xD0, ""), part);
            EXPECT_EQ(passed.failure, row.failure);
            EXPECT_EQ(passed.to_library, "");
            EXPECT_EQ(passed.to_broker, "");
        }
}

TEST(PacketGate, AcknowledgementsStandBetweenThePacketsToTheBroker) {
    PacketGate gate(kLimit);
    std::string ignored;
    std::string sent;
    const std::string own = publish(1, "data", 50);
    gate.to_broker(own.substr(0, 10), sent);
    gate.from_broker(publish(1, "t", 300), ignored);
    EXPECT_TRUE(gate.may_read());
    for (std::size_t i = 1; i < PacketGate::kMostAcknowledgements; ++i)
        gate.from_broker(publish(1, "t", 300), ignored);
    EXPECT_FALSE(gate.may_read());
    gate.to_broker({}, sent);
    EXPECT_EQ(sent, own.substr(0, 10));
    gate.to_broker(own.substr(10) + own, sent);
    EXPECT_TRUE(gate.may_read());
    std::string acknowledgements;
    for (std::size_t i = 0; i < PacketGate::kMostAcknowledgements; ++i)
        acknowledgements += "\x40\x02\x12\x34";
    EXPECT_EQ(sent, own + acknowledgements + own);
}

}  // namespace packet_gate_test
}  // namespace takt::publish
