#include "takt/console/traffic_log.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <thread>

#include "folder.hpp"
#include "support.hpp"
#include "takt/console/clock_text.hpp"
#include "takt/wire/frame_words.hpp"

namespace takt::console {
namespace traffic_log_test {

using namespace test;
using wire::Direction;
using ByteVector = std::vector<std::uint8_t>;

model::Line line_named(wire::Framing framing) {
    model::Line line;
    line.name = "main";
    line.port = "/dev/ttyS1";
    line.framing = framing;
    auto& device = line.devices.emplace_back();
    device.name = "Boiler";
    device.address = UnitId{16};
    return line;
}

class TrafficLogTest : public testing::Test {
protected:
    std::string written() {
        log.reset();
        return memory.text();
    }
    static std::string stamp(const std::string& rest) {
        return "[" + iso_time(Instant{2s}) + "] TRA : " + rest;
    }

    Memory memory;
    std::unique_ptr<TrafficLog> log = std::make_unique<TrafficLog>(memory.sink());
};

const ByteVector kRequest{0x03, 0, 7, 0, 1};
const ByteVector kResponse{0x03, 2, 0x12, 0x34};
const ByteVector kRequestFrame{16, 0x03, 0, 7, 0, 1, 0xAA, 0xBB};
const ByteVector kResponseFrame{16, 0x03, 2, 0x12, 0x34, 0xCC, 0xDD};

TEST_F(TrafficLogTest, AFrameHasItsNamesLengthBytesAndWords) {
    LineTraffic traffic(*log, line_named(wire::Framing::rtu), LineTraffic::Side::master);
    traffic.on_frame(Instant{2s}, Direction::sent, UnitId{16}, kRequest, kRequestFrame);
    traffic.on_frame(Instant{2s}, Direction::received, UnitId{16}, kResponse, kResponseFrame);
    const auto text = written();
    const auto first = text.substr(0, text.find('\n'));
    EXPECT_TRUE(
        first.starts_with(stamp("main::Boiler:(/dev/ttyS1) Tx: [0008] ") + wire::hex(kRequestFrame) + " | "))
        << first;
    EXPECT_NE(text.find("Rx: [0007] " + wire::hex(kResponseFrame)), std::string::npos);
    // the address is known from the request
    EXPECT_NE(text.find("registers 7 → 1 value: 4660"), std::string::npos) << text;
}

TEST_F(TrafficLogTest, AResponseToAnotherUnitHasNoAddress) {
    LineTraffic traffic(*log, line_named(wire::Framing::rtu), LineTraffic::Side::master);
    traffic.on_frame(Instant{2s}, Direction::sent, UnitId{16}, kRequest, kRequestFrame);
    traffic.on_frame(Instant{2s}, Direction::received, UnitId{17}, kResponse, kResponseFrame);
    const auto text = written();
    EXPECT_EQ(text.find("registers 7 → "), std::string::npos) << text;
    EXPECT_NE(text.find("unit 17"), std::string::npos);
}

TEST_F(TrafficLogTest, ASlaveReceivesRequests) {
    LineTraffic traffic(*log, line_named(wire::Framing::rtu), LineTraffic::Side::slave);
    traffic.on_frame(Instant{2s}, Direction::received, UnitId{16}, kRequest, kRequestFrame);
    traffic.on_frame(Instant{2s}, Direction::sent, UnitId{16}, kResponse, kResponseFrame);
    EXPECT_NE(written().find("registers 7 → 1 value: 4660"), std::string::npos) << memory.text();
}

TEST_F(TrafficLogTest, AsciiFramesAreTextWithoutTheirEnd) {
    LineTraffic traffic(*log, line_named(wire::Framing::ascii), LineTraffic::Side::master);
    const std::string frame = ":100300070001E5\r\n";
    traffic.on_frame(Instant{2s}, Direction::sent, UnitId{16}, kRequest,
                     ByteVector(frame.begin(), frame.end()));
    EXPECT_NE(written().find("[0017] :100300070001E5 | "), std::string::npos) << memory.text();
}

TEST_F(TrafficLogTest, DroppedBytesHaveAReason) {
    LineTraffic traffic(*log, line_named(wire::Framing::rtu), LineTraffic::Side::master);
    traffic.on_fault(Instant{2s}, wire::FrameFault::checksum, {});
    traffic.on_fault(Instant{2s}, wire::FrameFault::too_short, ByteVector{16, 3, 2});
    EXPECT_EQ(written(), stamp("main::(/dev/ttyS1) dropped: checksum wrong\n") +
                             stamp("main::(/dev/ttyS1) Rx: [0003] 10 03 02 | dropped: frame too short\n"));
}

TEST_F(TrafficLogTest, TheWordsAreInTheLanguageOfTheReader) {
    log = std::make_unique<TrafficLog>(memory.sink(), text::Language::russian);
    LineTraffic traffic(*log, line_named(wire::Framing::rtu), LineTraffic::Side::master);
    traffic.on_frame(Instant{2s}, wire::Direction::sent, UnitId{1}, kRequest, kRequestFrame);
    traffic.on_incident(Instant{2s}, UnitId{16}, wire::Incident::no_response, 200ms, {});
    EXPECT_EQ(written(), stamp("main::адрес 1:(/dev/ttyS1) Tx: [0008] 10 03 00 07 00 01 AA BB | "
                               "адрес 1 чтение регистров хранения 7\n") +
                             stamp("main::Boiler:(/dev/ttyS1) нет ответа в течение 200 мс\n"));
}

TEST_F(TrafficLogTest, WhatDidNotComeHasALine) {
    LineTraffic traffic(*log, line_named(wire::Framing::rtu), LineTraffic::Side::master);
    using wire::Incident;
    traffic.on_incident(Instant{2s}, UnitId{16}, Incident::late_response, 120ms, {});
    traffic.on_incident(Instant{2s}, UnitId{1}, Incident::surplus_response, {},
                        Mismatch{Mismatch::Part::unit, 1, 16});
    traffic.on_incident(Instant{2s}, UnitId{}, Incident::disconnected, {}, {});
    EXPECT_EQ(written(), stamp("main::Boiler:(/dev/ttyS1) late response: late by 120 ms\n") +
                             stamp("main::unit 1:(/dev/ttyS1) surplus response: a response of unit 1 came, "
                                   "unit 16 was asked\n") +
                             stamp("main::(/dev/ttyS1) disconnected\n"));
}

TEST_F(TrafficLogTest, AFactoryWithoutALogIsEmpty) {
    EXPECT_FALSE(traffic_factory(nullptr, LineTraffic::Side::master));
    const auto factory = traffic_factory(log.get(), LineTraffic::Side::master);
    ASSERT_TRUE(factory);
    factory(line_named(wire::Framing::rtu))->on_fault(Instant{2s}, wire::FrameFault::checksum, {});
    EXPECT_NE(written(), "");
}

TEST_F(TrafficLogTest, ATapWritesTheFramesOfAHost) {
    host::test::Rig rig(kPlant);
    const auto session = rig.open({.events = false, .traffic = true});
    rig.run(150ms);
    TapLog tap(*log);
    std::size_t frames = 0;
    while (const auto record = session->next_traffic()) {
        tap.put(*record, [&](const auto& of) { return session->line_of(of); });
        ++frames;
    }
    EXPECT_GE(frames, 2U);
    const auto text = written();
    EXPECT_EQ(static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')), frames);
    EXPECT_NE(text.find("main::Boiler:"), std::string::npos) << text;
    EXPECT_NE(text.find(" Tx: "), std::string::npos);
    EXPECT_NE(text.find(" Rx: "), std::string::npos);
}

TEST(TrafficLogFile, CannotBeOpenedBelowAFile) {
    const auto log = TrafficLog::open("/dev/null/traffic.log");
    ASSERT_FALSE(log);
    EXPECT_EQ(log.error().code, Code::cannot_open);
}

TEST(TrafficLogFile, IsRotated) {
    const takt::test::Folder folder;
    folder.write("traffic.log", "of an earlier run\n");
    {
        const auto log = TrafficLog::open(folder / "traffic.log", {}, 8);
        ASSERT_TRUE(log);
        for (const char* frame : {"frame 1", "frame 2", "frame 3"}) (*log)->put(frame);
    }
    EXPECT_EQ(folder.names(), (std::vector<std::string>{"traffic.log", "traffic.log.1", "traffic.log.2"}));
    EXPECT_EQ(folder.read("traffic.log"), "frame 3\n");
    EXPECT_EQ(folder.read("traffic.log.2"), "frame 1\n");
}

TEST(TrafficLogFile, ReportsThatItIsIncomplete) {
    std::string lost;
    int number = 0;
    std::atomic<int> failures = 0;
    {
        const auto log = TrafficLog::open("/dev/full", {.on_failed =
                                                            [&](const Error& error) {
                                                                EXPECT_EQ(error.subject.view(), "/dev/full");
                                                                EXPECT_EQ(error.numbers[0], ENOSPC);
                                                                ++failures;
                                                            },
                                                        .on_lost =
                                                            [&](const std::string& path, int why) {
                                                                lost = path;
                                                                number = why;
                                                            }});
        ASSERT_TRUE(log);
        (*log)->put("frame");
        while (failures == 0) std::this_thread::yield();  // the test's time limit is the check
        EXPECT_EQ(lost, "");
        for (int i = 0; i < 10; ++i) (*log)->put("frame");
    }
    EXPECT_EQ(failures, 1);
    EXPECT_EQ(lost, "/dev/full");
    EXPECT_EQ(number, ENOSPC);
}

TEST(TrafficLogFile, IsOfOneProgram) {
    const takt::test::Folder folder;
    const auto log = TrafficLog::open(folder / "traffic.log");
    ASSERT_TRUE(log);
    EXPECT_EQ(TrafficLog::open(folder / "traffic.log").error().code, Code::busy);
}

TEST(TrafficLogFile, ReportsOnceThatItIsNotRotated) {
    const takt::test::Folder folder;
    for (const char* number : {"1", "2", "3"}) folder.write("traffic.log." + std::string(number) + "/x", "");
    std::atomic<int> reports = 0;
    {
        const auto log =
            TrafficLog::open(folder / "traffic.log", {.on_not_rotated = [&](const Error&) { ++reports; }}, 8);
        ASSERT_TRUE(log);
        for (const char* frame : {"frame 1", "frame 2", "frame 3"}) (*log)->put(frame);
    }
    EXPECT_EQ(folder.read("traffic.log"), "frame 1\nframe 2\nframe 3\n");
    EXPECT_EQ(reports, 1);
}

}  // namespace traffic_log_test
}  // namespace takt::console
