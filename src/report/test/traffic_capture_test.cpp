#include "takt/report/traffic_capture.hpp"

#include <gtest/gtest.h>

#include <string>

namespace takt::report {
namespace {

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

TEST(TrafficCapture, DroppedBytesHaveTheirReason) {
    TrafficCapture capture([](const auto&) { return line_named("rs485-1", wire::Framing::rtu); });
    std::string file;
    auto record = request_of(1);
    record.fault = wire::FrameFault::checksum;
    capture.add(record, 5, file);
    EXPECT_NE(file.find("dropped: checksum"), std::string::npos);
}

}  // namespace
}  // namespace takt::report
