#include "takt/client/values.hpp"

#include <gtest/gtest.h>

#include "scripted_connection.hpp"

namespace takt::client {
namespace values_test {

using namespace test;
using wire::Area;

ReadSpec registers(std::uint16_t start, std::uint32_t count, DataType type = DataType::uint16) {
    ReadSpec spec;
    spec.start = start;
    spec.count = count;
    spec.layout.type = type;
    return spec;
}

std::vector<std::pair<int, int>> parts_of(const ReadSpec& spec) {
    std::vector<std::pair<int, int>> parts;
    for (const auto& request : read_requests(spec)) parts.emplace_back(request.start.value, request.quantity);
    return parts;
}

using Parts = std::vector<std::pair<int, int>>;

TEST(ReadRequests, DivideAtTheLimitAndNeverInsideAValue) {
    EXPECT_EQ(parts_of(registers(5, 1)), (Parts{{5, 1}}));
    EXPECT_EQ(parts_of(registers(0, 126)), (Parts{{0, 125}, {125, 1}}));
    // 125 registers hold 62 values of two, or 31 of four
    EXPECT_EQ(parts_of(registers(10, 63, DataType::float32)), (Parts{{10, 124}, {134, 2}}));
    EXPECT_EQ(parts_of(registers(0, 32, DataType::float64)), (Parts{{0, 124}, {124, 4}}));
    EXPECT_EQ(parts_of(registers(65535, 1)), (Parts{{65535, 1}}));
    auto strings = registers(0, 3, DataType::string);
    strings.layout.registers = 60;
    EXPECT_EQ(parts_of(strings), (Parts{{0, 120}, {120, 60}}));
}

TEST(ReadRequests, ABitIsAValueWithAnyType) {
    auto spec = registers(16, 2001, DataType::float64);
    spec.area = Area::discrete_input;
    EXPECT_EQ(spec.type(), DataType::boolean);
    EXPECT_EQ(spec.items(), 2001U);
    EXPECT_EQ(parts_of(spec), (Parts{{16, 2000}, {2016, 1}}));
    EXPECT_EQ(read_requests(spec)[0].function, wire::Function::read_discrete_inputs);
}

TEST(ReadValues, GivesEachValueItsAddress) {
    Rig rig({{1ms, {0x03, 8, 0, 0, 0x41, 0x20, 0, 0, 0x41, 0x70}}});
    auto spec = registers(100, 2, DataType::float32);
    spec.layout.order = {true, false};
    std::vector<ReadValue> values;
    ASSERT_TRUE(read_values(*rig.client, spec, values));
    ASSERT_EQ(values.size(), 2U);
    EXPECT_EQ(values[0].address, 100);
    EXPECT_EQ(values[0].value, value::Value(10.0));
    EXPECT_EQ(values[1].address, 102);
    EXPECT_EQ(values[1].value, value::Value(15.0));
}

TEST(ReadValues, KeepsWhatWasReadBeforeAnError) {
    ByteVector whole(252, 1);
    whole[0] = 0x03;
    whole[1] = 250;
    Rig rig({{1ms, whole}, {1ms, {0x83, 2}}});
    std::vector<ReadValue> values;
    const auto done = read_values(*rig.client, registers(0, 200), values);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, Code::modbus_exception);
    EXPECT_EQ(values.size(), 125U);
    EXPECT_EQ(values.back().address, 124);
}

TEST(ReadValues, BitsBeginWithTheLowestOfTheFirstByte) {
    Rig rig({{1ms, {0x01, 2, 0b10, 0b1}}});
    ReadSpec spec;
    spec.area = Area::coil;
    spec.start = 20;
    spec.count = 9;
    std::vector<ReadValue> values;
    ASSERT_TRUE(read_values(*rig.client, spec, values));
    ASSERT_EQ(values.size(), 9U);
    EXPECT_EQ(values[0].value, value::Value(false));
    EXPECT_EQ(values[1].value, value::Value(true));
    EXPECT_EQ(values[8].value, value::Value(true));
    EXPECT_EQ(values[8].address, 28);
}

WriteSpec write(Area area, std::vector<std::string> values, DataType type = DataType::uint16) {
    WriteSpec spec;
    spec.area = area;
    spec.values = std::move(values);
    spec.layout.type = type;
    return spec;
}

TEST(WriteParts, ASingleItemHasFunctionsOfItsOwn) {
    using wire::Function;
    const auto function = [](WriteSpec spec, bool multiple) {
        spec.multiple = multiple;
        const auto parts = write_parts(spec);
        EXPECT_TRUE(parts);
        EXPECT_EQ(parts->size(), 1U);
        return wire::function_of(parts->front().request);
    };
    EXPECT_EQ(function(write(Area::coil, {"true"}), false), Function::write_single_coil);
    EXPECT_EQ(function(write(Area::coil, {"true"}), true), Function::write_multiple_coils);
    EXPECT_EQ(function(write(Area::holding_register, {"7"}), false), Function::write_single_register);
    EXPECT_EQ(function(write(Area::holding_register, {"7"}), true), Function::write_multiple_registers);
    EXPECT_EQ(function(write(Area::holding_register, {"7", "8"}), false), Function::write_multiple_registers);
    EXPECT_EQ(function(write(Area::holding_register, {"7"}, DataType::int32), false),
              Function::write_multiple_registers);
}

TEST(WriteParts, DivideAtTheLimitAndNeverInsideAValue) {
    const auto parts =
        write_parts(write(Area::holding_register, std::vector<std::string>(62, "1.5"), DataType::float32));
    ASSERT_TRUE(parts);
    ASSERT_EQ(parts->size(), 2U);  // 123 registers hold 61 values of two
    EXPECT_EQ((*parts)[0].end, 122U);
    EXPECT_EQ((*parts)[1].end, 124U);
    const auto& second = std::get<wire::WriteMultipleRegistersRequest>((*parts)[1].request);
    EXPECT_EQ(second.start.value, 122);
    EXPECT_EQ(second.values.size(), 2U);
}

TEST(WriteParts, AStringHasTheRegistersOfItsText) {
    const auto parts = write_parts(write(Area::holding_register, {"abc"}, DataType::string));
    ASSERT_TRUE(parts);
    EXPECT_EQ(parts->back().end, 2U);
}

TEST(WriteParts, RejectsTextThatIsNoValue) {
    EXPECT_FALSE(write_parts(write(Area::holding_register, {"1", "seven"})));
    EXPECT_FALSE(write_parts(write(Area::holding_register, {"70000"})));
    EXPECT_FALSE(write_parts(write(Area::coil, {"2"})));
}

TEST(WriteValues, TheOutcomeDependsOnWhatTheDeviceMayHaveDone) {
    const auto parts =
        *write_parts(write(Area::holding_register, std::vector<std::string>(124, "1"), DataType::uint16));
    const ByteVector confirmed{0x10, 0, 0, 0, 123};
    const auto outcome = [&](std::vector<Reply> replies) {
        Rig rig(std::move(replies));
        const auto written = write_values(*rig.client, parts);
        EXPECT_EQ(written.function, wire::Function::write_multiple_registers);
        return std::pair{std::string(written.outcome()), written.items};
    };
    using Outcome = std::pair<std::string, std::size_t>;
    EXPECT_EQ(outcome({{1ms, confirmed}, {1ms, {0x10, 0, 123, 0, 1}}}), Outcome("done", 124));
    EXPECT_EQ(outcome({{1ms, confirmed}}), Outcome("partly", 123));
    EXPECT_EQ(outcome({{1ms, {0x90, 4}}}), Outcome("refused", 0));
    EXPECT_EQ(outcome({}), Outcome("unknown", 0));
}

}  // namespace values_test
}  // namespace takt::client
