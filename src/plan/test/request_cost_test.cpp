// The cost by which reads are chosen against the bus time of the requests.
#include "cost/request_cost.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "builder.hpp"

namespace takt::plan {
namespace request_cost_test {

using namespace test;
using wire::Framing;

model::Project some_project() {
    Settings settings{16, *rc::gen::element(Framing::rtu, Framing::ascii, Framing::tcp)};
    auto made = project(settings, {});
    model::Line& line = made.lines[0];
    line.format.baud = *rc::gen::element<std::uint32_t>(1200, 9600, 19200, 38400, 115200, 921600);
    line.frame_gap = *rc::gen::element<Duration>(0ms, 3ms);
    line.request_gap = *rc::gen::element<Duration>(0ms, 12ms, 40ms);
    model::Device& device = line.devices[0];
    device.turnaround = *rc::gen::element<std::optional<Duration>>(std::nullopt, 0ms, 5ms, 50ms);
    device.round_trip = *rc::gen::element<Duration>(200us, 1ms, 30ms);
    return made;
}

RC_GTEST_PROP(RequestCost, IsTheBusTimeOfEachLength, ()) {
    const auto made = some_project();
    const model::Line& line = made.lines[0];
    const model::Device& device = line.devices[0];
    const auto function =
        *rc::gen::element(wire::Function::read_coils, wire::Function::read_discrete_inputs,
                          wire::Function::read_holding_registers, wire::Function::read_input_registers);
    const RequestCost cost = read_cost(line, device, function);
    const BusTimeModel bus_times(line);
    const auto most = static_cast<std::uint32_t>(wire::max_items(line.framing, function));
    for (std::uint32_t items = 1; items <= most; ++items) {
        const auto [asked, answered] = frame_lengths(line.framing, function, items);
        RC_ASSERT(cost(items) ==
                  bus_times.transaction(device, asked, answered, estimated_turnaround(device)));
        RC_ASSERT((cost(items) <= cost.floor) == (items <= cost.items_at_floor()));
    }
}

// 0x03 of 10 registers on TCP: 12 + 29 bytes, round trip 1 ms; times in units of half a nanosecond.
TEST(RequestCost, SharesTheRoundTripAmongRequestsInFlight) {
    auto made = project({16, Framing::tcp}, {});
    model::Line& line = made.lines[0];
    model::Device& device = line.devices[0];
    device.in_flight = 4;
    const auto cost = [&] { return read_cost(line, device, wire::Function::read_holding_registers)(10); };
    EXPECT_TRUE(cost() == 2 * (1'000'000 + 4 * 41 * 10));
    line.frame_gap = 1ms;
    EXPECT_TRUE(cost() == 2 * (1'000'000 + 4 * (1'000'000 + 41 * 10)));
    line.request_gap = 2ms;
    EXPECT_TRUE(cost() == 2 * 4 * 2'000'000);
}

TEST(RequestCost, OfASerialLineKnowsNoRequestsInFlight) {
    auto made = project({16}, {});
    model::Device& device = made.lines[0].devices[0];
    const auto alone = read_cost(made.lines[0], device, wire::Function::read_coils);
    device.in_flight = 4;
    EXPECT_TRUE(read_cost(made.lines[0], device, wire::Function::read_coils)(1) == alone(1));
}

TEST(RequestCost, KnowsTheItemsBelowItsFloor) {
    EXPECT_EQ((RequestCost{0, 10, 1, 1}.items_at_floor()), 0U);
    EXPECT_EQ((RequestCost{10, 10, 1, 1}.items_at_floor()), 0U);
    EXPECT_EQ((RequestCost{11, 10, 1, 1}.items_at_floor()), 1U);
    EXPECT_EQ((RequestCost{29, 10, 3, 8}.items_at_floor()), 48U);
    EXPECT_EQ((RequestCost{10, 10, 0, 1}.items_at_floor()), 65536U);
    EXPECT_EQ((RequestCost{ExactTime{1} << 90, 1, 1, 8}.items_at_floor()), 65536U);
}

}  // namespace request_cost_test
}  // namespace takt::plan
