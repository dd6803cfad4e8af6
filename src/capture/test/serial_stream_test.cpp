#include "serial/serial_stream.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "capture_bytes.hpp"

namespace takt::capture {
namespace serial_stream_test {

using test::hex;
using test::joined;
using test::Octets;

const Octets kRequest = hex("01 03 00 00 00 02 C4 0B");
const Octets kResponse = hex("01 03 04 12 34 AB CD 00 20");

struct Messages final : AduSink {
    std::vector<Octets> pdus;
    std::vector<std::uint64_t> packets;
    void on_adu(const Adu& adu) override {
        pdus.emplace_back(adu.pdu.begin(), adu.pdu.end());
        packets.push_back(adu.packet.number);
        EXPECT_EQ(adu.unit, 1);
    }
};

TEST(SerialStream, FramesAreCutAnywhere) {
    const auto all = joined({kRequest, kResponse, kRequest});
    for (std::size_t piece = 1; piece <= all.size(); ++piece) {
        SerialStream stream(wire::Framing::rtu);
        Messages messages;
        for (std::size_t at = 0; at < all.size(); at += piece)
            stream.push({at / piece + 1, 1000}, Bytes(all).subspan(at, std::min(piece, all.size() - at)),
                        messages);
        ASSERT_EQ(messages.pdus.size(), 3u) << piece;
        EXPECT_EQ(messages.pdus[1], hex("03 04 12 34 AB CD"));
        EXPECT_EQ(messages.packets[0], (kRequest.size() - 1) / piece + 1);
        EXPECT_EQ(stream.skipped_bytes(), 0u);
    }
}

TEST(SerialStream, OtherBytesAreSkipped) {
    SerialStream stream(wire::Framing::rtu);
    Messages messages;
    stream.push({1, 1000}, hex("01 03 00"), messages);
    stream.begin();  // a gap
    stream.push({2, 2000}, kRequest, messages);
    EXPECT_EQ(messages.pdus.size(), 1u);
    EXPECT_EQ(stream.skipped_bytes(), 3u);
}

TEST(SerialStream, Ascii) {
    SerialStream stream(wire::Framing::ascii);
    Messages messages;
    const std::string text = ":010300000002FA\r\n";
    stream.push({1, 1000}, Bytes(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()), messages);
    ASSERT_EQ(messages.pdus.size(), 1u);
    EXPECT_EQ(messages.pdus[0], hex("03 00 00 00 02"));
}

TEST(SerialStream, TimesThatGoBackwardsAreAccepted) {
    SerialStream stream(wire::Framing::rtu);
    Messages messages;
    stream.push({1, 5000}, kRequest, messages);
    stream.push({2, 1000}, kRequest, messages);
    EXPECT_EQ(messages.pdus.size(), 2u);
}

}  // namespace serial_stream_test
}  // namespace takt::capture
