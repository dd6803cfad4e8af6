#include "takt/capture/serial_packet.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "capture_bytes.hpp"
#include "network/upper_pdu.hpp"
#include "takt/capture/frame_capture.hpp"

namespace takt::capture {
namespace serial_packet_test {

using namespace test;

/// Each packet of a capture as its sender or state and its bytes.
struct Seen final : PacketSink {
    std::vector<std::string> all;

    void on_packet(const Packet& packet) override {
        const SerialPacket serial(packet);
        const bool damaged = serial.kind() == SerialPacket::Kind::damaged;
        std::string text = damaged ? "damaged" : "none";
        if (serial.kind() == SerialPacket::Kind::frame)
            text = serial.sender() == Sender::master  ? "master"
                   : serial.sender() == Sender::slave ? "slave"
                                                      : "frame";
        text += " " + std::string(packet.interface_name);
        for (const auto byte : serial.bytes()) text += " " + std::to_string(byte);
        all.push_back(text);
    }
};

std::vector<std::string> seen_in(const std::string& file) {
    Seen seen;
    CaptureReader reader(seen);
    const auto space = reader.space();
    std::copy(file.begin(), file.end(), space.begin());
    EXPECT_TRUE(reader.filled(file.size()));
    reader.end();
    EXPECT_FALSE(reader.error());
    return seen.all;
}

const Octets kPdu = hex("07");
const Octets kRtu = hex("10 07 4D B2");
const Octets kAscii{':', '1', '0', '0', '7', 'E', '9', '\r', '\n'};

struct SerialPacketTest : testing::Test {
    FrameCapture capture;
    std::string file;

    SerialPacketTest() { capture.begin_file(file); }
    void add(CapturedFrame frame) {
        frame.line_name = "rs485";
        frame.unit = 16;
        capture.add(frame, file);
    }
};

TEST_F(SerialPacketTest, TheFramesOfTaktsOwnCaptures) {
    using wire::Framing;
    add({.framing = Framing::rtu, .request = true, .pdu = kPdu, .raw = kRtu, .device = "Pump | left"});
    add({.framing = Framing::rtu, .pdu = kPdu, .raw = kRtu});
    capture.add_loss(3);
    add({.framing = Framing::ascii, .request = true, .pdu = kPdu, .raw = kAscii, .device = "Pump"});
    add({.framing = Framing::rtu, .raw = kRtu, .fault = "checksum"});
    EXPECT_EQ(seen_in(file), (std::vector<std::string>{"master rs485 16 7 77 178", "slave rs485 16 7 77 178",
                                                       "master rs485 58 49 48 48 55 69 57 13 10",
                                                       "damaged rs485 16 7 77 178"}));
}

TEST_F(SerialPacketTest, ACommentThatIsNotTheFrameOfItsPacketIsNone) {
    append_interface(file, LinkType::raw, "eth0");
    const auto packet_of = [&](const std::string& comment) {
        FrameCapture other;
        std::string packet;
        other.begin_file(packet);
        const auto head = packet.size();
        other.add({.framing = wire::Framing::rtu, .unit = 16, .pdu = kPdu, .raw = kRtu}, packet);
        struct Keep final : PacketSink {
            std::string data;
            void on_packet(const Packet& read) override {
                data.assign(reinterpret_cast<const char*>(read.data.data()), read.data.size());
            }
        } keep;
        CaptureReader reader(keep);
        std::copy(packet.begin(), packet.end(), reader.space().begin());
        EXPECT_TRUE(reader.filled(packet.size()));
        EXPECT_GT(packet.size(), head);
        append_packet(file, {.data = keep.data, .comment = comment});
    };
    for (const auto* comment : {"", "10 07 4D B3", "11 07 4C 22", "10 07 4D B", "10 7 4D B2", "10 07 4d b2",
                                "10:07:4D:B2", "words", ":1007E8", ":", " | ", "10 07 4D B2 |"})
        packet_of(comment);
    packet_of("10 07 4D B2");
    auto seen = seen_in(file);
    ASSERT_FALSE(seen.empty());
    EXPECT_EQ(seen.back(), "slave eth0 16 7 77 178");
    seen.pop_back();
    for (const auto& text : seen) EXPECT_EQ(text, "none eth0");
}

TEST_F(SerialPacketTest, ExportedPdusAreUnwrapped) {
    append_interface(file, LinkType::upper_pdu, "");
    const std::string frame(kRtu.begin(), kRtu.end());
    append_packet(file, {.data = upper_pdu(kRtuDissector, frame)});
    append_packet(file, {.data = upper_pdu(kDataDissector, frame)});
    append_packet(file, {.data = upper_pdu("http", frame)});
    EXPECT_EQ(seen_in(file),
              (std::vector<std::string>{"frame  16 7 77 178", "damaged  16 7 77 178", "none "}));
}

}  // namespace serial_packet_test
}  // namespace takt::capture
