#include "takt/capture/frame_capture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "network/upper_pdu.hpp"
#include "takt/capture/analysis.hpp"
#include "takt/capture/capture_reader.hpp"
#include "takt/capture/segment.hpp"

namespace takt::capture {
namespace frame_capture_test {

const std::vector<std::uint8_t> kRequest{0x03, 0x00, 0x00, 0x00, 0x01};
const std::vector<std::uint8_t> kResponse{0x03, 0x02, 0x12, 0x34};

/// Keeps the packets of a capture.
struct Packets final : PacketSink {
    struct Kept {
        Packet packet;
        std::string data;
    };
    std::vector<Kept> all;
    void on_packet(const Packet& packet) override {
        all.push_back({packet, {reinterpret_cast<const char*>(packet.data.data()), packet.data.size()}});
    }
};

template <class Sink>
void read(std::string_view file, Sink& sink) {
    CaptureReader reader(sink);
    while (!file.empty()) {
        const auto space = reader.space();
        const auto count = std::min(space.size(), file.size());
        std::copy_n(file.begin(), count, space.begin());
        file.remove_prefix(count);
        ASSERT_TRUE(reader.filled(count));
    }
    reader.end();
    ASSERT_FALSE(reader.error());
}

std::vector<Packets::Kept> packets_of(const std::string& file) {
    Packets packets;
    read(file, packets);
    return packets.all;
}

Segment segment_of(const Packets::Kept& kept) {
    Packet packet = kept.packet;
    packet.data = {reinterpret_cast<const std::uint8_t*>(kept.data.data()), kept.data.size()};
    Segment segment;
    Fragment fragment;
    EXPECT_EQ(decode_segment(packet, segment, fragment), Content::segment);
    return segment;
}

std::uint32_t sum16(std::string_view bytes) {
    std::uint32_t sum = 0;
    for (std::size_t i = 0; i < bytes.size(); i += 2)
        sum += std::uint32_t{static_cast<unsigned char>(bytes[i])} << 8U |
               (i + 1 < bytes.size() ? static_cast<unsigned char>(bytes[i + 1]) : 0U);
    while (sum > 0xFFFF) sum = (sum & 0xFFFFU) + (sum >> 16U);
    return sum;
}

struct FrameCaptureTest : testing::Test {
    FrameCapture capture;
    std::string file;

    FrameCaptureTest() { capture.begin_file(file); }
    void add(CapturedFrame frame) {
        frame.line_name = frame.line_name.empty() ? "line" : frame.line_name;
        capture.add(frame, file);
    }
};

TEST_F(FrameCaptureTest, SerialFramesAreModbusTcpWithConsistentSequenceNumbers) {
    add({.wall_ns = 0x100000002,
         .framing = wire::Framing::rtu,
         .request = true,
         .unit = 16,
         .pdu = kRequest});
    add({.wall_ns = 0x100000003, .framing = wire::Framing::rtu, .unit = 16, .pdu = kResponse});
    const auto packets = packets_of(file);
    ASSERT_EQ(packets.size(), 2u);
    EXPECT_EQ(packets[0].packet.time_ns, 0x100000002);
    EXPECT_EQ(packets[0].packet.link, LinkType::raw);
    EXPECT_EQ(packets[0].data.substr(40),
              std::string("\x00\x01\x00\x00\x00\x06\x10\x03\x00\x00\x00\x01", 12));
    const auto sent = segment_of(packets[0]);
    const auto received = segment_of(packets[1]);
    EXPECT_EQ(sent.destination.port, 502);
    EXPECT_EQ(received.source, sent.destination);
    EXPECT_EQ(received.acknowledged, sent.sequence + sent.payload.size());
    EXPECT_EQ(received.payload[1], 1);  // the identifier of the request
}

TEST_F(FrameCaptureTest, ALateResponseHasTheIdentifierOfItsRequest) {
    const std::vector<std::uint8_t> inputs{0x04, 0x00, 0x00, 0x00, 0x01};
    const std::vector<std::uint8_t> exception{0x84, 0x06};
    const std::vector<std::uint8_t> other{0x02, 0x01, 0x00};
    const std::pair<bool, const std::vector<std::uint8_t>&> frames[] = {
        {true, inputs}, {true, kRequest}, {false, exception}, {false, kResponse}, {false, other}};
    for (const auto& [request, pdu] : frames)
        add({.framing = wire::Framing::rtu, .request = request, .unit = 16, .pdu = pdu});
    std::vector<int> identifiers;
    for (const auto& packet : packets_of(file)) identifiers.push_back(segment_of(packet).payload[1]);
    EXPECT_EQ(identifiers, (std::vector<int>{1, 2, 1, 2, 2}));
}

TEST_F(FrameCaptureTest, ChecksumsAreRight) {
    add({.request = true, .unit = 1, .pdu = kRequest});
    add({.request = true, .unit = 1, .pdu = kRequest, .client = "[2001:db8::7]:50100"});
    const auto packets = packets_of(file);
    const auto& v4 = packets[0].data;
    EXPECT_EQ(sum16(v4.substr(0, 20)), 0xFFFFu);
    EXPECT_EQ(sum16(v4.substr(12, 8) + std::string("\0\6\0\x20", 4) + v4.substr(20)), 0xFFFFu);
    const auto& v6 = packets[1].data;
    EXPECT_EQ(sum16(v6.substr(8, 32) + std::string("\0\6\0\x20", 4) + v6.substr(40)), 0xFFFFu);
    EXPECT_EQ(segment_of(packets[1]).source.port, 50100);
    EXPECT_EQ(segment_of(packets[1]).source.address, *parse_ip("2001:db8::7"));
}

TEST_F(FrameCaptureTest, TcpFramesKeepTheirBytesAndAddresses) {
    const std::vector<std::uint8_t> raw{0xAB, 0xCD, 0, 0, 0, 6, 1, 3, 0, 0, 0, 1};
    add({.request = true,
         .unit = 1,
         .pdu = kRequest,
         .raw = raw,
         .client = "192.0.2.7:50100",
         .server = "192.0.2.9"});
    const auto packets = packets_of(file);
    const auto segment = segment_of(packets.at(0));
    EXPECT_TRUE(std::ranges::equal(segment.payload, raw));
    EXPECT_EQ(segment.source.address, *parse_ip("192.0.2.7"));
    EXPECT_EQ(segment.destination.address, *parse_ip("192.0.2.9"));
}

TEST_F(FrameCaptureTest, KeepsLinesUnitsAndPeersApart) {
    const std::vector<std::uint8_t> pdu{0x07};
    const auto rtu = wire::Framing::rtu;
    add({.line = 0, .framing = rtu, .request = true, .unit = 1, .pdu = pdu});
    add({.line = 0, .framing = rtu, .request = true, .unit = 2, .pdu = pdu});
    add({.line = 0, .framing = rtu, .request = false, .unit = 1, .pdu = pdu});
    add({.line = 1, .framing = rtu, .request = true, .unit = 1, .pdu = pdu});
    add({.line = 1, .framing = rtu, .request = false, .unit = 9, .pdu = pdu});
    add({.line = 1, .framing = rtu, .request = true, .unit = 1, .pdu = pdu, .client = "192.0.2.7:50100"});
    std::vector<int> identifiers;
    const auto packets = packets_of(file);
    for (const auto& packet : packets) identifiers.push_back(segment_of(packet).payload[1]);
    EXPECT_EQ(identifiers, (std::vector<int>{1, 2, 1, 1, 2, 1}));
    EXPECT_EQ(packets[0].packet.interface, 0u);
    EXPECT_EQ(packets[3].packet.interface, 1u);
    EXPECT_NE(segment_of(packets[0]).destination, segment_of(packets[3]).destination);
}

TEST_F(FrameCaptureTest, SerialBytesAreInTheComment) {
    const std::vector<std::uint8_t> raw{0x10, 0x03, 0xAB};
    const std::string text = ":1003AB\r\n";
    const Bytes ascii{reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
    add({.framing = wire::Framing::rtu, .unit = 16, .pdu = kRequest, .raw = raw, .device = "Boiler"});
    add({.framing = wire::Framing::ascii, .unit = 16, .pdu = kRequest, .raw = ascii});
    EXPECT_NE(file.find("Boiler | 10 03 AB"), std::string::npos);
    EXPECT_NE(file.find(":1003AB"), std::string::npos);
    EXPECT_EQ(file.find(text), std::string::npos);
}

TEST_F(FrameCaptureTest, DroppedBytesAreData) {
    const std::vector<std::uint8_t> raw{0x10, 0x03, 0xAB};
    add({.framing = wire::Framing::rtu, .raw = raw, .fault = "checksum"});
    const auto packet = packets_of(file).at(0);
    EXPECT_EQ(packet.packet.link, LinkType::upper_pdu);
    const auto upper =
        decode_upper_pdu({reinterpret_cast<const std::uint8_t*>(packet.data.data()), packet.data.size()});
    ASSERT_TRUE(upper);
    EXPECT_EQ(upper->dissector, "data");
    EXPECT_TRUE(std::ranges::equal(upper->payload, raw));
    EXPECT_NE(file.find("dropped: checksum"), std::string::npos);
}

TEST_F(FrameCaptureTest, LossesAreReportedOnceAndCountedAtTheEnd) {
    capture.add_loss(3);
    add({.unit = 1, .pdu = kRequest});
    add({.unit = 1, .pdu = kRequest});
    const auto first = file.find("3 frames before this one were lost");
    ASSERT_NE(first, std::string::npos);
    EXPECT_EQ(file.find("were lost", first + 40), std::string::npos);
    const auto size = file.size();
    capture.end_file(5, file);
    const auto block = file.substr(size);
    EXPECT_EQ(block[0], 5);   // interface statistics
    EXPECT_EQ(block[24], 5);  // isb_ifrecv: 2 captured and 3 lost
    EXPECT_EQ(block[36], 3);  // isb_ifdrop
    Packets packets;
    CaptureReader reader(packets);
    std::ranges::copy(file, reader.space().begin());
    EXPECT_TRUE(reader.filled(file.size()));
    EXPECT_EQ(packets.all.size(), 2u);
    EXPECT_EQ(reader.dropped(), 3u);
}

TEST_F(FrameCaptureTest, LossesCountInTheFileInWhichTheyCome) {
    capture.add_loss(3);
    capture.begin_file(file);
    EXPECT_EQ(capture.lost(), 0u);
    add({.unit = 1, .pdu = kRequest});
    EXPECT_NE(file.find("3 frames before this one were lost"), std::string::npos);
}

TEST_F(FrameCaptureTest, EachFileHasItsInterfacesAndConnectionsContinue) {
    add({.request = true, .unit = 1, .pdu = kRequest});
    const auto first = packets_of(file);
    const auto before = segment_of(first.at(0));
    file.clear();
    capture.begin_file(file);
    add({.request = true, .unit = 1, .pdu = kRequest});
    const auto second = packets_of(file);
    EXPECT_EQ(segment_of(second.at(0)).sequence, before.sequence + before.payload.size());
}

TEST_F(FrameCaptureTest, AnEmptyFileCanEnd) {
    capture.end_file(5, file);
    EXPECT_TRUE(packets_of(file).empty());
}

/// Counts exchanges.
struct Exchanges final : ExchangeSink {
    int requests = 0;
    int responses = 0;
    void on_request(const ObservedRequest&) override { ++requests; }
    void on_response(const ObservedRequest&, const ObservedResponse&) override { ++responses; }
    void on_no_response(const ObservedRequest&, NoResponse) override {}
};

TEST_F(FrameCaptureTest, IsReadAsExchanges) {
    for (int i = 0; i < 3; ++i) {
        add({.framing = wire::Framing::ascii, .request = true, .unit = 16, .pdu = kRequest});
        add({.framing = wire::Framing::ascii, .unit = 16, .pdu = kResponse});
    }
    add({.framing = wire::Framing::ascii, .raw = kRequest, .fault = "checksum"});
    Exchanges exchanges;
    Analysis analysis({}, std::chrono::seconds(1), exchanges);
    read(file, analysis);
    analysis.end();
    EXPECT_EQ(exchanges.requests, 3);
    EXPECT_EQ(exchanges.responses, 3);
    EXPECT_EQ(analysis.serial().damaged, 1u);
}

TEST(UpperPdu, CutTagsAreNone) {
    const auto packet = upper_pdu("mbrtu", "abc");
    for (std::size_t size = 0; size + 3 < packet.size(); ++size)
        EXPECT_FALSE(decode_upper_pdu({reinterpret_cast<const std::uint8_t*>(packet.data()), size})) << size;
}

}  // namespace frame_capture_test
}  // namespace takt::capture
