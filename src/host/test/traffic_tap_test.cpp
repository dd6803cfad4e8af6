#include "takt/host/traffic_tap.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace takt::host {
namespace traffic_tap_test {

const std::vector<std::uint8_t> kPdu{3, 2, 0, 1};

TEST(TrafficTap, ReadsWhatObserversSee) {
    TrafficTap tap;
    model::Line line;
    line.name = "server";
    const auto observer = tap.factory()(line);
    auto reader = tap.reader();
    EXPECT_FALSE(reader.next());
    observer->on_peer("192.0.2.7:50100");
    observer->on_frame(Instant(Duration(9)), wire::Direction::received, UnitId{17}, kPdu, kPdu);
    observer->on_fault(Instant(Duration(10)), wire::FrameFault::bad_header, kPdu);
    const auto frame = reader.next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->peer, "192.0.2.7:50100");
    EXPECT_EQ(frame->pdu, kPdu);
    EXPECT_EQ(reader.line_of(*frame)->name, "server");
    const auto fault = reader.next();
    ASSERT_TRUE(fault);
    EXPECT_EQ(fault->fault, wire::FrameFault::bad_header);
    EXPECT_EQ(fault->raw, kPdu);
    EXPECT_FALSE(reader.next());
    EXPECT_TRUE(tap.reader().next()) << "each reader has a position of its own";
}

TEST(TrafficTap, CountsWhatWasOverwritten) {
    TrafficTap tap;
    const auto observer = tap.factory()(model::Line{});
    auto reader = tap.reader();
    const int many = 100'000;
    for (int i = 0; i < many; ++i)
        observer->on_frame(Instant(Duration(i)), wire::Direction::received, UnitId{17}, kPdu, kPdu);
    int left = 0;
    while (reader.next()) ++left;
    EXPECT_GT(left, 1000);
    EXPECT_EQ(reader.missed() + static_cast<std::uint64_t>(left), static_cast<std::uint64_t>(many));
}

}  // namespace traffic_tap_test
}  // namespace takt::host
