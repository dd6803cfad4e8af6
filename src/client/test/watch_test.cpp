#include "takt/client/watch.hpp"

#include <gtest/gtest.h>

#include "scripted_connection.hpp"

namespace takt::client {
namespace watch_test {

using namespace test;
using wire::Area;

WatchSpec spec_of(std::vector<WatchedRange> ranges, DataType type = DataType::uint16) {
    return {.ranges = std::move(ranges),
            .layout = {.type = type},
            .period = 500ms,
            .name = [](Area area, std::uint32_t address) {
                return std::string(wire::name(area)) + ' ' + std::to_string(address);
            }};
}

Options options() {
    Options options;
    options.target = "tcp://plc";
    options.unit = 17;
    return options;
}

TEST(WatchProject, IsOneDeviceWithTheItemsInTheirOrder) {
    const auto project = watch_project(
        options(), spec_of({{Area::holding_register, 10, 2}, {Area::coil, 33, 1}}, DataType::int32));
    ASSERT_TRUE(project);
    ASSERT_EQ(project->lines.size(), 1U);
    EXPECT_EQ(project->lines[0].port, "plc");
    const auto& device = project->lines[0].devices.at(0);
    EXPECT_EQ(device.address.value, 17);
    EXPECT_EQ(device.poll_period, Duration(500ms));
    ASSERT_EQ(device.variables.size(), 3U);
    EXPECT_EQ(device.variables[0].name, "holding_register 10");
    EXPECT_EQ(device.variables[1].name, "holding_register 12");
    EXPECT_EQ(device.variables[1].items(), 2);
    EXPECT_EQ(device.variables[2].name, "coil 33");
    EXPECT_EQ(device.variables[2].start(), 33);
    EXPECT_EQ(device.variables[2].type, DataType::boolean);
}

TEST(WatchProject, ARangeMayHaveATypeOfItsOwn) {
    WatchedRange range{Area::holding_register, 10, 2};
    range.type = DataType::float32;
    auto ordered = range;
    ordered.order = ByteOrder{true, true};
    const auto project = watch_project(
        options(), spec_of({{Area::holding_register, 10, 2}, range, ordered, ordered}, DataType::int16));
    ASSERT_TRUE(project);
    const auto& variables = project->lines[0].devices.at(0).variables;
    ASSERT_EQ(variables.size(), 6U) << "an item in another type or order is another value";
    EXPECT_EQ(variables[1].name, "holding_register 11");
    EXPECT_EQ(variables[3].name, "holding_register 12 float");
    EXPECT_EQ(variables[3].type, DataType::float32);
    EXPECT_EQ(variables[3].items(), 2);
    EXPECT_EQ(variables[5].name, "holding_register 12 float ABCD");
    EXPECT_EQ(variables[5].order, (ByteOrder{true, true}));
}

TEST(WatchProject, TakesAnItemThatTwoRangesNameOnce) {
    const auto project = watch_project(options(), spec_of({{Area::holding_register, 5, 3},
                                                           {Area::holding_register, 7, 2},
                                                           {Area::input_register, 7, 1}}));
    ASSERT_TRUE(project);
    EXPECT_EQ(project->lines[0].devices[0].variables.size(), 5U);
}

TEST(WatchProject, RejectsWhatIsBeyondTheAreaOrTooMuch) {
    const auto beyond =
        watch_project(options(), spec_of({{Area::holding_register, 65535, 1}}, DataType::float32));
    ASSERT_FALSE(beyond);
    EXPECT_EQ(beyond.error().code, Code::out_of_range);
    EXPECT_TRUE(watch_project(options(), spec_of({{Area::coil, 0, kMaxWatched}})));
    const auto more = watch_project(options(), spec_of({{Area::coil, 0, kMaxWatched + 1}}));
    ASSERT_FALSE(more);
    EXPECT_EQ(more.error().code, Code::too_long);
    auto elsewhere = options();
    elsewhere.target = "plc:502";
    EXPECT_EQ(watch_project(elsewhere, spec_of({})).error().code, Code::syntax);
}

TEST(ReadVariables, DecodesTheVariablesOfARequestOfThePlan) {
    const auto project = watch_project(
        options(),
        spec_of({{Area::holding_register, 10, 1}, {Area::holding_register, 11, 1}, {Area::coil, 3, 2}}));
    ASSERT_TRUE(project);
    const auto plan = plan::make_plan(*project);
    const auto& variables = project->lines[0].devices[0].variables;
    const auto& requests = plan.lines[0].requests;
    ASSERT_EQ(requests.size(), 2U);  // neighbours share one
    const bool coils_first = is_bit_area(variables[requests[0].variables[0]].area);
    const Reply registers{1ms, {0x03, 4, 0, 7, 0, 8}};
    const Reply coils{1ms, {0x01, 1, 0b10}};
    Rig rig(coils_first ? std::vector{coils, registers} : std::vector{registers, coils});
    std::vector<value::Value> values(variables.size());
    for (const auto& request : requests) {
        auto read = read_variables(*rig.client, request, variables);
        ASSERT_TRUE(read);
        ASSERT_EQ(read->size(), request.variables.size());
        for (std::size_t i = 0; i < read->size(); ++i) values[request.variables[i]] = (*read)[i];
    }
    EXPECT_EQ(values[0], value::Value(std::uint64_t{7}));
    EXPECT_EQ(values[1], value::Value(std::uint64_t{8}));
    EXPECT_EQ(values[2], value::Value(false));
    EXPECT_EQ(values[3], value::Value(true));
    EXPECT_EQ(read_variables(*rig.client, requests[0], variables).error().code, Code::timed_out);
}

}  // namespace watch_test
}  // namespace takt::client
