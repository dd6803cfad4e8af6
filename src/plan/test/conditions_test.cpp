// The table of conditions and the single rules (docs/specification.md, section 4).
#include <gtest/gtest.h>

#include "builder.hpp"

namespace takt::plan {
namespace conditions_test {

using namespace test;
using model::Strategy;

struct Condition {
    const char* name;
    std::vector<Item> items;
    std::size_t entries;
};

const Item kRead = int16(0).read(3);
const Item kWritten = int16(0).write(0x10).on_change();

std::vector<Item> three(const Item& first, const Item& second, const Item& third) {
    return {first, second, third};
}

// Two neighbours, the second changed.
template <class Change>
std::vector<Item> pair(const Item& first, Change change) {
    auto items = row(2, first);
    items[1] = change(items[1]);
    return items;
}

class Conditions : public testing::TestWithParam<Condition> {};

TEST_P(Conditions, DecideWhatIsGrouped) {
    const auto plan = plan_of({16}, GetParam().items);
    EXPECT_EQ(plan.requests.size(), GetParam().entries);
}

INSTANTIATE_TEST_SUITE_P(
    Section4, Conditions,
    testing::Values(
        Condition{"SameType", row(3, real(0).read(3)), 1},
        Condition{"RealThenInt16", {real(0).read(3), int16(2).read(3)}, 2},
        Condition{"NoGaps", three(real(0).read(3), real(2).read(3), real(4).read(3)), 1},
        Condition{"Gap", {real(0).read(3), real(3).read(3)}, 2},
        Condition{"Overlap", {real(0).read(3), real(1).read(3)}, 2},
        Condition{"SamePlace", {real(0).read(3), real(0).read(3)}, 2},
        Condition{"OtherFunction", pair(kRead, [](const Item& v) { return v.read(4); }), 2},
        Condition{"SamePeriod", row(2, kRead), 1},
        Condition{"OtherPeriod", pair(kRead, [](const Item& v) { return v.every(200ms); }), 2},
        Condition{"OneReadTrigger", row(2, kRead.read_on(0)), 1},
        Condition{"OtherReadTrigger", pair(kRead.read_on(0), [](const Item& v) { return v.read_on(1); }), 2},
        Condition{"OneWithoutReadTrigger", pair(kRead, [](const Item& v) { return v.read_on(0); }), 2},
        Condition{"OneWriteTrigger", row(2, kWritten.write_on(0)), 1},
        Condition{"OtherWriteTrigger",
                  pair(kWritten.write_on(0), [](const Item& v) { return v.write_on(1); }), 2},
        Condition{"ReadTriggerOfAVariableOnlyWritten",
                  pair(kWritten, [](const Item& v) { return v.read_on(0); }), 1},
        Condition{"NoStatus", row(2, kRead), 1}, Condition{"OneStatus", row(2, kRead.reports_to(0)), 1},
        Condition{"OtherStatus", pair(kRead.reports_to(0), [](const Item& v) { return v.reports_to(1); }), 2},
        Condition{"OnlyOneStatus", pair(kRead, [](const Item& v) { return v.reports_to(0); }), 2},
        Condition{"Int32AndUint32", {int32(0).read(3), item(DataType::uint32, 2).read(3)}, 1},
        Condition{"Int16AndUint16", {int16(0).read(3), item(DataType::uint16, 1).read(3)}, 1},
        Condition{"Int64AndUint64", {item(DataType::int64, 0).read(3), item(DataType::uint64, 4).read(3)}, 1},
        Condition{
            "Int64AndDouble", {item(DataType::int64, 0).read(3), item(DataType::float64, 4).read(3)}, 2},
        Condition{"StringsOfOneLength",
                  {item(DataType::string, 0, 4).read(3), item(DataType::string, 4, 4).read(3)},
                  1},
        Condition{"StringsOfTwoLengths",
                  {item(DataType::string, 0, 4).read(3), item(DataType::string, 4, 5).read(3)},
                  2},
        Condition{"OtherWriteFunction",
                  {boolean(0, 0).write(0x0F).on_change(), boolean(0, 1).write(0x05).on_change()},
                  2},
        Condition{"OtherWriteOnChange",
                  pair(int16(0).write(0x10).write_on(0), [](const Item& v) { return v.on_change(); }), 2},
        Condition{"WriteSingleCoil",
                  {boolean(0, 0).write(0x05).on_change(), boolean(0, 1).write(0x05).on_change()},
                  2},
        Condition{"WriteSingleRegister", row(3, int16(0).write(0x06).on_change()), 3},
        Condition{"WriteSeveralCoils",
                  {boolean(0, 0).write(0x0F).on_change(), boolean(0, 1).write(0x0F).on_change()},
                  1},
        Condition{"WrittenByCommandOnly", row(2, int16(0).write(0x10)), 0},
        Condition{"ReadAndWrittenByCommand", row(2, kRead.write(0x10)), 1},
        Condition{"Unused", row(2, kRead.unused()), 0},
        Condition{"UnusedInBetween", three(kRead, int16(1).read(3).unused(), int16(2).read(3)), 2},
        Condition{"HoleBetweenBits", {boolean(0, 0).read(1), boolean(0, 2).read(1)}, 2},
        Condition{"BoolsOfARegisterAreNotWritten", {boolean(0, 0).read(3).write(0x10).on_change()}, 1},
        Condition{
            "WriteSingleCoilOfReadGroup",
            {boolean(0, 0).read(1).write(0x05).on_change(), boolean(0, 1).read(1).write(0x05).on_change()},
            3},
        Condition{"WriteSingleCoilOfReadSingle", {boolean(0, 0).read(1).write(0x05).on_change()}, 1}),
    [](const auto& tested) { return tested.param.name; });

std::vector<std::vector<std::string>> names(const model::Project& project, const LinePlan& plan) {
    std::vector<std::vector<std::string>> names;
    for (const Request& request : plan.requests) {
        auto& members = names.emplace_back();
        for (const std::size_t index : request.variables)
            members.push_back(project.lines[plan.line].devices[request.device].variables[index].name);
    }
    return names;
}

using Names = std::vector<std::vector<std::string>>;

// a and c are read, so the read pass numbers them 1 and 2; b gets 3: 1, 3, 2 in the order of the registers.
TEST(OrderConflict, EndsAWriteGroup) {
    const auto made = project({16}, {int16(0).read(3).write(0x10).on_change().named("a"),
                                     int16(1).write(0x10).on_change().named("b"),
                                     int16(2).read(3).write(0x10).on_change().named("c")});
    const auto plan = make_plan(made).lines[0];
    EXPECT_EQ(names(made, plan), (Names{{"a"}, {"c"}, {"b"}})) << "a and c merged, b written alone";
    EXPECT_EQ(plan.requests[2].why.code, "plan.order_conflict");
}

// The read pass sorts 0x03 before 0x04 and coils before both: the numbers count through all functions.
TEST(OrderConflict, ComesFromTheOrderOfFunctions) {
    const auto made =
        project({16}, {int16(0).read(3).write(0x10).on_change().named("a"),
                       int16(1).write(0x10).on_change().named("b"), int16(9).read(4).named("x")});
    EXPECT_EQ(names(made, make_plan(made).lines[0]), (Names{{"a"}, {"x"}, {"b"}}))
        << "x took number 2, so b has 3";
    const auto without = project({16}, {int16(0).read(3).write(0x10).on_change().named("a"),
                                        int16(1).write(0x10).on_change().named("b")});
    EXPECT_EQ(names(without, make_plan(without).lines[0]), (Names{{"a"}, {"a", "b"}}))
        << "1 and 2 adjoin, but the groups differ in size";
}

TEST(Devices, NeverShareARequestAndGoByAddress) {
    auto made = project({16}, {});
    made.lines[0].devices = {device(20, {16}, row(2, kRead)), device(3, {16}, row(2, int16(2).read(3)))};
    const auto plan = make_plan(made).lines[0];
    ASSERT_EQ(plan.requests.size(), 2U);
    EXPECT_EQ(plan.requests[0].device, 1U) << "unit 3 before unit 20";
    EXPECT_EQ(plan.requests[1].device, 0U);
}

TEST(Devices, EachHasItsOwnStrategy) {
    auto made = project({16}, {});
    Settings single{16};
    single.strategy = Strategy::single;
    Settings optimal{16};
    optimal.strategy = Strategy::optimal;
    made.lines[0].devices = {device(1, single, row(4, kRead)), device(2, {16}, row(4, kRead)),
                             device(3, optimal, row(4, kRead))};
    EXPECT_EQ(make_plan(made).lines[0].requests.size(), 4U + 1U + 1U);
    EXPECT_EQ(make_plan(made).lines[0].ungrouped_requests, 12U);
    EXPECT_EQ(make_plan(made, {.strategy = Strategy::single}).lines[0].requests.size(), 12U);
    EXPECT_EQ(make_plan(made, {.strategy = Strategy::classic}).lines[0].requests.size(), 3U);
}

TEST(Single, MakesOneEntryOfEachUsedVariable) {
    Settings settings{16};
    settings.strategy = Strategy::single;
    const auto made = project(
        settings, {boolean(0, 1).read(1).write(0x05).on_change().named("coil"),
                   real(4).read(3).write(0x10).named("commanded"),
                   real(2).write(0x10).on_change().named("written"), real(0).read(3).unused().named("unused"),
                   real(8).named("bare"), real(6).write(0x10).named("only commanded")});
    const auto plan = make_plan(made).lines[0];
    EXPECT_EQ(names(made, plan), (Names{{"coil"}, {"commanded"}, {"written"}, {"only commanded"}}));
    EXPECT_EQ(plan.requests[0].write, wire::Function::write_single_coil);
    EXPECT_EQ(plan.requests[0].start, 1);
    EXPECT_EQ(plan.requests[1].write, wire::Function::write_multiple_registers);
    EXPECT_EQ(plan.requests[2].read, std::nullopt);
    EXPECT_EQ(plan.request_count, plan.ungrouped_requests);
}

TEST(Plans, AreEmptyForEmptyProjects) {
    EXPECT_TRUE(make_plan({}).lines.empty());
    const auto plan = plan_of({16}, {});
    EXPECT_TRUE(plan.requests.empty());
    EXPECT_EQ(plan.cycle, 0ns);
    EXPECT_EQ(plan.utilization, 0);
}

}  // namespace conditions_test
}  // namespace takt::plan
