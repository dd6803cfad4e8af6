// Bus time (docs/planning.md, "Bus time") against figures worked out by hand.
#include <gtest/gtest.h>

#include "builder.hpp"

namespace takt::plan {
namespace bus_time_test {

using namespace test;
using wire::Framing;
using wire::Parity;

struct Case {
    const char* arithmetic;
    Framing framing;
    wire::CharacterFormat format;
    std::size_t request, response;
    Duration turnaround;
    Duration request_gap, frame_gap;
    std::int64_t nanoseconds;
};

constexpr wire::CharacterFormat k115200n{115200, 8, Parity::none, 1};  // 10 bits
constexpr wire::CharacterFormat k38400n2{38400, 8, Parity::none, 2};   // 11 bits
constexpr wire::CharacterFormat k19200e{19200, 8, Parity::even, 1};    // 11 bits
constexpr wire::CharacterFormat k9600e{9600, 8, Parity::even, 1};      // 11 bits
constexpr wire::CharacterFormat k9600e7{9600, 7, Parity::even, 1};     // 10 bits

const Case kCases[] = {
    // 0x03 of 20 registers: 8 + 45 characters
    {"1.75 ms + 5 ms + 53 * 10 / 115200 s = 11.350 694 44 ms", Framing::rtu, k115200n, 8, 45, 5ms, 0ms, 0ms,
     11'350'695},
    // 0x03 of 2 registers: 8 + 9
    {"1.75 ms + 5 ms + 17 * 10 / 115200 s = 8.225 694 44 ms", Framing::rtu, k115200n, 8, 9, 5ms, 0ms, 0ms,
     8'225'695},
    {"1.75 ms + 1.75 ms (more than 1 ms) + 17 * 10 / 115200 s = 4.975 694 44 ms", Framing::rtu, k115200n, 8,
     9, 1ms, 0ms, 0ms, 4'975'695},
    // 38400 8N2, 0x03 of 1 register: 8 + 7
    {"1.75 ms + 5 ms + 15 * 11 / 38400 s = 11.046 875 ms", Framing::rtu, k38400n2, 8, 7, 5ms, 0ms, 0ms,
     11'046'875},
    // the last bit rate with a variable silence
    {"(38.5 + 15 * 11) / 19200 s + 5 ms = 15.598 958 33 ms", Framing::rtu, k19200e, 8, 7, 5ms, 0ms, 0ms,
     15'598'959},
    {"(38.5 + 38.5 + 15 * 11) / 9600 s = 25.208 333 33 ms: t3.5 above 2 ms", Framing::rtu, k9600e, 8, 7, 2ms,
     0ms, 0ms, 25'208'334},
    {"(38.5 + 15 * 11) / 9600 s + 5 ms = 26.197 916 67 ms", Framing::rtu, k9600e, 8, 7, 5ms, 0ms, 0ms,
     26'197'917},
    // ASCII, 0x03 of 1 register: 2 * (1 + 5 + 1) + 3 = 17, 2 * (1 + 4 + 1) + 3 = 15
    {"32 * 10 / 9600 s + 5 ms = 38.333 333 33 ms", Framing::ascii, k9600e7, 17, 15, 5ms, 0ms, 0ms,
     38'333'334},
    {"the same + 3 ms", Framing::ascii, k9600e7, 17, 15, 5ms, 0ms, 3ms, 41'333'334},
    // TCP, 0x03 of 1 register: 12 + 11 bytes, round trip 1 ms
    {"1 ms + 23 * 10 ns", Framing::tcp, k115200n, 12, 11, 5ms, 0ms, 0ms, 1'000'230},
    {"2 ms + 1 ms + 23 * 10 ns", Framing::tcp, k115200n, 12, 11, 5ms, 0ms, 2ms, 3'000'230},
    {"stretched to 12 ms", Framing::rtu, k115200n, 8, 9, 5ms, 12ms, 0ms, 12'000'000},
    {"8.23 ms is longer than 8 ms", Framing::rtu, k115200n, 8, 9, 5ms, 8ms, 0ms, 8'225'695},
    {"TCP stretched to 4 ms", Framing::tcp, k115200n, 12, 11, 5ms, 4ms, 2ms, 4'000'000},
    {"3 ms + 5 ms + 17 * 10 / 115200 s", Framing::rtu, k115200n, 8, 9, 5ms, 0ms, 3ms, 9'475'695},
    {"a frame gap of 1 ms is less than t3.5", Framing::rtu, k115200n, 8, 9, 5ms, 0ms, 1ms, 8'225'695},
};

model::Line line_of(const Case& tested) {
    auto line = project({16, tested.framing}, {}).lines[0];
    line.format = tested.format;
    line.request_gap = tested.request_gap;
    line.frame_gap = tested.frame_gap;
    return line;
}

TEST(BusTime, IsAsWorkedOutByHand) {
    for (const Case& tested : kCases) {
        const auto line = line_of(tested);
        EXPECT_EQ(bus_time(line, line.devices[0], tested.request, tested.response, tested.turnaround).count(),
                  tested.nanoseconds)
            << tested.arithmetic;
    }
}

TEST(BusTime, OfRtuOverTcpIsThatOfTheConnection) {
    auto line = project({16, Framing::tcp}, {}).lines[0];
    line.framing = Framing::rtu;
    line.devices[0].round_trip = 3ms;
    EXPECT_EQ(bus_time(line, line.devices[0], 8, 7, 5ms), 3ms + 150ns);
}

TEST(BusTime, OfASimulatedSerialLineIsThatOfARealOne) {
    auto line = project({16, Framing::rtu}, {}).lines[0];
    const auto real = bus_time(line, line.devices[0], 8, 45, 5ms);
    line.transport = model::Transport::simulated;
    EXPECT_EQ(bus_time(line, line.devices[0], 8, 45, 5ms), real);
}

TEST(BusTime, StaysFiniteAtTheEndsOfTheRanges) {
    auto line = project({16, Framing::ascii}, {}).lines[0];
    line.format = {1, 8, Parity::even, 2};
    line.frame_gap = line.request_gap = Duration::max();
    EXPECT_EQ(bus_time(line, line.devices[0], 513, 513, Duration::max()), Duration::max());
    line.frame_gap = line.request_gap = 0ns;
    EXPECT_EQ(bus_time(line, line.devices[0], 513, 513, 0ns), 1026 * 12s);
}

TEST(Turnaround, IsEstimatedWhereItIsUnknown) {
    model::Device device;
    EXPECT_EQ(estimated_turnaround(device), 5ms);
    device.turnaround = 60ms;
    EXPECT_EQ(estimated_turnaround(device), 60ms);
    device.times.measured = {.exchanges = 100, .longest = 9ms, .p999 = 3ms};
    device.learn_turnaround = true;
    EXPECT_EQ(estimated_turnaround(device), 60ms);
    device.turnaround.reset();
    EXPECT_EQ(estimated_turnaround(device), 3ms) << "without the longest 0.1 %";
    device.learn_turnaround = false;
    EXPECT_EQ(estimated_turnaround(device), 5ms);
}

TEST(Requests, KnowTheirFramesAndTime) {
    struct Frames {
        Framing framing;
        Item item;
        std::size_t request, response;
    };
    const Frames cases[] = {
        {Framing::rtu, real(0).read(3), 8, 9},
        {Framing::rtu, boolean(0, 3).read(1), 8, 6},
        {Framing::rtu, real(0).write(0x10).on_change(), 13, 8},
        {Framing::rtu, boolean(0, 3).write(0x05).on_change(), 8, 8},
        {Framing::rtu, boolean(0, 3).write(0x0F).on_change(), 10, 8},
        {Framing::rtu, real(0).read(3).write(0x10).on_change(), 8, 9},  // merged: its read
        {Framing::ascii, real(0).read(3), 17, 19},
        {Framing::tcp, real(0).read(3), 12, 13},
    };
    for (const auto& [framing, item, request_bytes, response_bytes] : cases) {
        const auto made = project({16, framing}, {item});
        const Request request = make_plan(made).lines[0].requests.at(0);
        EXPECT_EQ(request.request_bytes, request_bytes);
        EXPECT_EQ(request.response_bytes, response_bytes);
        const auto& line = made.lines[0];
        EXPECT_EQ(request.bus_time, bus_time(line, line.devices[0], request_bytes, response_bytes, 5ms));
    }
}

// Ten times 8.225 694 44… ms are 82.256 944 44… ms: rounded up once, not ten times.
TEST(Cycle, IsRoundedOnce) {
    Settings single{16};
    single.strategy = model::Strategy::single;
    const auto plan = plan_of(single, row(10, real(0).read(3)));
    EXPECT_EQ(plan.requests[0].bus_time, 8'225'695ns);
    EXPECT_EQ(plan.cycle, 82'256'945ns);
    EXPECT_NEAR(plan.utilization, 0.822569444, 1e-9);
}

TEST(Cycle, LeavesOutWhatIsOnlyWritten) {
    const auto read = row(4, int16(0).read(3));
    auto both = read;
    for (const Item& item : row(4, int16(10).write(0x10).on_change())) both.push_back(item);
    const auto plan = plan_of({16}, both);
    ASSERT_EQ(plan.requests.size(), 2U);
    EXPECT_EQ(plan.cycle, plan_of({16}, read).cycle);
    EXPECT_EQ(plan.utilization, plan_of({16}, read).utilization);
}

TEST(Utilization, LeavesOutWhatIsPolledAsFastAsTheLineAllows) {
    const auto plan = plan_of({16}, {int16(0).read(3).every(0ms), real(4).read(3).every(10ms)});
    EXPECT_NEAR(plan.utilization, 0.8225694444, 1e-9) << "8.2256944 ms every 10 ms";
    EXPECT_EQ(plan.cycle, plan.requests[0].bus_time + plan.requests[1].bus_time - 1ns);
}

TEST(Utilization, IsAboveOneForALineThatCannotHoldItsPeriods) {
    EXPECT_NEAR(plan_of({16}, {real(0).read(3).every(5ms)}).utilization, 1.6451388889, 1e-9);
}

}  // namespace bus_time_test
}  // namespace takt::plan
