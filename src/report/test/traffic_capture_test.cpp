#include "takt/report/times/traffic_capture.hpp"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "takt/capture/capture_reader.hpp"
#include "takt/capture/segment.hpp"

namespace takt::report {
namespace traffic_capture_test {

model::Line line_named(const std::string& name, wire::Framing framing) {
    model::Line line;
    line.name = name;
    line.framing = framing;
    model::Device device;
    device.name = "Boiler";
    device.address = UnitId{16};
    line.devices.push_back(device);
    return line;
}

host::TrafficRecord request_of(std::uint32_t generation) {
    host::TrafficRecord record;
    record.generation = generation;
    record.unit = UnitId{16};
    record.pdu = {0x07};
    record.raw = {0x10, 0x07, 0xC1, 0xC2};
    return record;
}

TEST(TrafficCapture, NamesLinesAndDevices) {
    TrafficCapture capture([](const auto&) { return line_named("rs485-1", wire::Framing::rtu); });
    std::string file;
    capture.frames().begin_file(file);
    capture.add(request_of(1), 5, file);
    EXPECT_NE(file.find("rs485-1"), std::string::npos);
    EXPECT_NE(file.find("Boiler | 10 07 C1 C2"), std::string::npos);
}

TEST(TrafficCapture, ALineThatIsForgottenIsALoss) {
    TrafficCapture capture([](const auto&) { return std::nullopt; });
    std::string file;
    capture.add(request_of(1), 5, file);
    EXPECT_EQ(capture.frames().lost(), 1u);
    EXPECT_TRUE(file.empty());
}

TEST(TrafficCapture, ALineStaysTheSameInterfaceAfterAReload) {
    TrafficCapture capture([](const auto&) { return line_named("rs485-1", wire::Framing::rtu); });
    std::string file;
    capture.add(request_of(1), 5, file);
    capture.add(request_of(2), 6, file);
    const auto first = file.find("rs485-1");
    EXPECT_EQ(file.find("rs485-1", first + 1), std::string::npos);
}

TEST(TrafficCapture, ASentFrameHasTheTimeOfItsLastCharacter) {
    auto line = line_named("rs485-1", wire::Framing::rtu);
    line.transport = model::Transport::simulated;
    line.format = {.baud = 9600, .parity = wire::Parity::none, .stop_bits = 1};
    TrafficCapture capture([&](const auto&) { return line; });
    auto record = request_of(1);
    EXPECT_EQ(capture.end_of(record) - record.t, wire::transmission_time(line.format, 4));
    record.direction = wire::Direction::received;
    EXPECT_EQ(capture.end_of(record), record.t);
    line.transport = model::Transport::tcp;
    record = request_of(2);
    EXPECT_EQ(capture.end_of(record), record.t) << "RTU over TCP";
}

/// The PDUs that the capture has as requests, and as responses.
struct Sides final : capture::PacketSink {
    std::string requests;
    std::string responses;

    void on_packet(const capture::Packet& packet) override {
        capture::Segment segment;
        capture::Fragment fragment;
        ASSERT_EQ(capture::decode_segment(packet, segment, fragment), capture::Content::segment);
        auto& text = segment.destination.port == 502 ? requests : responses;
        for (const auto byte : segment.payload.subspan(6)) text += fmt::format("{:02x}", byte);
        text += ' ';
    }
};

TEST(TrafficCapture, TheResponseOfAnotherSlaveIsNoRequest) {
    TrafficCapture capture([](const auto&) { return line_named("/dev/ttyUSB0", wire::Framing::rtu); });
    std::string file;
    capture.frames().begin_file(file);
    auto record = request_of(1);
    record.source.kind = host::TrafficSource::Kind::endpoint;
    const auto add = [&](std::uint8_t unit, wire::Direction direction, std::vector<std::uint8_t> pdu) {
        record.unit = UnitId{unit};
        record.direction = direction;
        record.pdu = std::move(pdu);
        record.t += std::chrono::milliseconds(5);
        capture.add(record, 5, file);
    };
    using wire::Direction;
    for (int i = 0; i < 2; ++i) {  // the second time the unit is known as its own
        add(16, Direction::received, {0x06, 0, 1, 0, 2});
        add(16, Direction::sent, {0x06, 0, 1, 0, 2});
    }
    add(16, Direction::received, {0x06, 0, 1, 0, 2});
    add(16, Direction::received, {0x06, 0, 1, 0, 2});
    add(2, Direction::received, {0x03, 0, 0, 0, 2});
    add(2, Direction::received, {0x03, 4, 0, 1, 0, 2});
    add(3, Direction::received, {0x06, 0, 1, 0, 2});
    add(3, Direction::received, {0x06, 0, 1, 0, 2});
    add(4, Direction::received, {0x83, 2});
    add(0, Direction::received, {0x06, 0, 1, 0, 2});
    Sides sides;
    capture::CaptureReader reader(sides);
    const auto space = reader.space();
    std::copy(file.begin(), file.end(), space.begin());
    ASSERT_TRUE(reader.filled(file.size()));
    EXPECT_EQ(sides.requests,
              "100600010002 100600010002 100600010002 100600010002 020300000002 030600010002 000600010002 ");
    EXPECT_EQ(sides.responses, "100600010002 100600010002 02030400010002 030600010002 048302 ");
}

TEST(TrafficCapture, DroppedBytesHaveTheirReason) {
    TrafficCapture capture([](const auto&) { return line_named("rs485-1", wire::Framing::rtu); });
    std::string file;
    auto record = request_of(1);
    record.fault = wire::FrameFault::checksum;
    capture.add(record, 5, file);
    EXPECT_NE(file.find("dropped: checksum"), std::string::npos);
}

}  // namespace traffic_capture_test
}  // namespace takt::report
