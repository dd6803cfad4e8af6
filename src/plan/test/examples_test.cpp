// The worked examples and the table of limits (docs/specification.md, sections 3 and 5), each as a plan.
#include <gtest/gtest.h>

#include "builder.hpp"
#include "requests/boundary.hpp"

namespace takt::plan {
namespace examples_test {

using namespace test;
using model::Profile;
using model::Strategy;
using wire::Framing;

std::vector<Item> reals_at(std::initializer_list<int> registers) {
    std::vector<Item> items;
    for (const int at : registers) items.push_back(real(at).read(3));
    return items;
}

std::vector<Item> bits(std::initializer_list<std::pair<int, int>> places) {
    std::vector<Item> items;
    for (const auto& [at, bit] : places) items.push_back(boolean(at, bit).read(1));
    return items;
}

std::vector<Item> read_and_written(int count) {
    return row(count, int16(0).read(3).write(0x10).on_change());
}

// On change: yes, yes, no, no.
std::vector<Item> half_on_change() {
    auto items = row(4, int16(0).read(3).write(0x10));
    items[0] = items[0].on_change();
    items[1] = items[1].on_change();
    return items;
}

std::vector<Item> half_on_change_with_trigger() {
    auto items = half_on_change();
    for (Item& item : items) item = item.write_on(0);
    return items;
}

std::vector<Item> scenario_1() {
    return row(10, real(0).read(3));
}

std::vector<Item> scenario_3() {
    return {int16(500).read(3).read_on(0), int16(501).read(3).read_on(0),
            int16(506).read(4).read_on(1).every(50ms)};
}

struct Span {
    std::uint16_t start;
    std::uint16_t quantity;
    friend bool operator==(const Span&, const Span&) = default;
    friend std::ostream& operator<<(std::ostream& out, const Span& span) {
        return out << span.start << "+" << span.quantity;
    }
};

std::vector<Span> spans(const LinePlan& plan) {
    std::vector<Span> spans;
    for (const Request& request : plan.requests) spans.push_back({request.start, request.quantity});
    return spans;
}

struct Example {
    const char* name;
    Settings settings;
    std::vector<Item> items;
    std::size_t count;           // of the source
    std::vector<Span> requests;  // where they lie
};

class Examples : public testing::TestWithParam<Example> {};

TEST_P(Examples, ComeOutExactly) {
    const auto plan = plan_of(GetParam().settings, GetParam().items);
    EXPECT_EQ(plan.request_count, GetParam().count);
    EXPECT_EQ(spans(plan), GetParam().requests);
}

INSTANTIATE_TEST_SUITE_P(
    Section5, Examples,
    testing::Values(
        Example{"AnyOrder", {16}, reals_at({2, 8, 6, 4, 10}), 1, {{2, 10}}},
        Example{"Gap", {5}, reals_at({0, 2, 6, 8}), 2, {{0, 4}, {6, 4}}},
        Example{"FiveRegistersAtMostThree", {3}, row(5, int16(0).read(3)), 2, {{0, 3}, {3, 2}}},
        Example{"ThreeDoubleRegistersAtMostFour", {4}, row(3, real(0).read(3)), 2, {{0, 4}, {4, 2}}},
        Example{"FloatBesideInt", {16}, {real(0).read(3), int32(2).read(3)}, 1, {{0, 4}}},
        Example{"ThreeTypes",
                {16},
                {boolean(0, 0).read(3), int16(1).read(3), real(2).read(3)},
                3,
                {{0, 1}, {1, 1}, {2, 2}}},
        Example{"BitsOfOneRegister", {16}, bits({{2, 4}, {2, 5}, {2, 6}}), 1, {{36, 3}}},
        Example{"BitsOfTwoRegisters", {16}, bits({{0, 14}, {0, 15}, {1, 0}}), 2, {{14, 2}, {16, 1}}},
        Example{"BitsInsideAHoldingRegister",
                {16},
                {boolean(7, 0).read(3), boolean(7, 1).read(3), boolean(7, 2).read(3)},
                1,
                {{7, 1}}},
        Example{
            "AsciiTwoRegisterInts", {61, Framing::ascii}, row(31, int32(0).read(3)), 2, {{0, 60}, {60, 2}}},
        Example{
            "AsciiOneRegisterInts", {61, Framing::ascii}, row(62, int16(0).read(4)), 2, {{0, 61}, {61, 1}}},
        Example{"AsciiWrittenOnly",
                {61, Framing::ascii, Profile::owen_kc1},
                row(30, int32(0).write(0x10).on_change()),
                2,
                {{0, 58}, {58, 2}}},
        Example{"RtuWrittenOnly", {125}, row(62, int32(0).write(0x10).on_change()), 2, {{0, 122}, {122, 2}}},
        Example{"TwoReadFunctions", {16}, {int16(5).read(3), int16(5).read(4)}, 2, {{5, 1}, {5, 1}}},
        Example{"ReadAndWritten", {16}, read_and_written(4), 1, {{0, 4}}},
        Example{"HalfOnChange", {16}, half_on_change(), 2, {{0, 4}, {0, 2}}},
        Example{"HalfOnChangeWithTrigger", {16}, half_on_change_with_trigger(), 3, {{0, 4}, {0, 2}, {2, 2}}},
        Example{"Scenario1", {125}, scenario_1(), 1, {{0, 20}}},
        Example{"Scenario1AtMost20", {20}, scenario_1(), 1, {{0, 20}}},
        Example{"Scenario2",
                {125, Framing::rtu, Profile::generic, Strategy::single},
                scenario_1(),
                10,
                {{0, 2}, {2, 2}, {4, 2}, {6, 2}, {8, 2}, {10, 2}, {12, 2}, {14, 2}, {16, 2}, {18, 2}}},
        Example{"Scenario3", {16}, scenario_3(), 4, {{500, 2}, {506, 1}}},
        Example{"Scenario3Ungrouped",
                {16, Framing::rtu, Profile::generic, Strategy::single},
                scenario_3(),
                6,
                {{500, 1}, {501, 1}, {506, 1}}}),
    [](const auto& tested) { return tested.param.name; });

TEST(Examples, CountWhatGroupingSaves) {
    EXPECT_EQ(plan_of({125}, scenario_1()).ungrouped_requests, 10U);
    EXPECT_EQ(plan_of({16}, scenario_3()).ungrouped_requests, 6U);
    EXPECT_EQ(plan_of({16}, half_on_change_with_trigger()).ungrouped_requests, 4U);
}

TEST(Examples, MergedEntryCarriesBothSides) {
    auto items = read_and_written(3);
    for (Item& item : items) item = item.read_on(1).write_on(2).reports_to(3).every(250ms);
    const auto plan = plan_of({16}, items);
    ASSERT_EQ(plan.requests.size(), 1U);
    const Request& merged = plan.requests[0];
    EXPECT_EQ(merged.read, wire::Function::read_holding_registers);
    EXPECT_EQ(merged.write, wire::Function::write_multiple_registers);
    EXPECT_EQ(merged.variables, (std::vector<std::size_t>{0, 1, 2}));
    EXPECT_EQ(merged.period, 250ms);
    EXPECT_EQ(merged.read_trigger, 1U);
    EXPECT_EQ(merged.write_trigger, 2U);
    EXPECT_EQ(merged.status, 3U);
    EXPECT_TRUE(merged.write_on_change);
    EXPECT_EQ(merged.count(), 2U) << "period and start-reading trigger count each";
}

TEST(Examples, SeparateEntriesCarryTheirOwnSide) {
    const auto plan = plan_of({16}, half_on_change_with_trigger());
    ASSERT_EQ(plan.requests.size(), 3U);
    const Request& read = plan.requests[0];
    EXPECT_EQ(read.write, std::nullopt);
    EXPECT_EQ(read.write_trigger, std::nullopt);
    EXPECT_FALSE(read.write_on_change);
    const Request& on_change = plan.requests[1];
    EXPECT_EQ(on_change.read, std::nullopt);
    EXPECT_EQ(on_change.period, std::nullopt);
    EXPECT_EQ(on_change.write_trigger, 0U);
    EXPECT_TRUE(on_change.write_on_change);
    EXPECT_FALSE(plan.requests[2].write_on_change);
}

// ---- section 3

struct LimitCase {
    Framing framing;
    Profile profile;
    int function;
    std::size_t items;
};

constexpr LimitCase kLimits[] = {
    {Framing::rtu, Profile::owen_kc1, 0x03, 125},   {Framing::rtu, Profile::owen_kc1, 0x04, 125},
    {Framing::rtu, Profile::owen_kc1, 0x10, 123},   {Framing::rtu, Profile::owen_kc1, 0x01, 125},
    {Framing::rtu, Profile::owen_kc1, 0x02, 125},   {Framing::rtu, Profile::owen_kc1, 0x0F, 125},
    {Framing::ascii, Profile::owen_kc1, 0x03, 61},  {Framing::ascii, Profile::owen_kc1, 0x04, 61},
    {Framing::ascii, Profile::owen_kc1, 0x10, 59},  {Framing::ascii, Profile::owen_kc1, 0x01, 125},
    {Framing::ascii, Profile::owen_kc1, 0x02, 125}, {Framing::ascii, Profile::owen_kc1, 0x0F, 125},
    {Framing::ascii, Profile::generic, 0x03, 125},  {Framing::ascii, Profile::generic, 0x10, 123},
};

TEST(Limits, FollowFramingFunctionAndBuffer) {
    for (const auto& [framing, profile, function, items] : kLimits) {
        const auto made = project({125, framing, profile}, {});
        const ItemLimit limit(made, made.lines[0], made.lines[0].devices[0],
                              static_cast<wire::Function>(function));
        EXPECT_EQ(limit.items(), items) << name(framing) << " " << function;
    }
}

TEST(Limits, CutRequestsOfRegisters) {
    for (const auto& [framing, profile, function, items] : kLimits) {
        if (wire::counts_bits(static_cast<wire::Function>(function))) continue;
        const Item first = function == 0x10 ? int16(0).write(0x10).on_change() : int16(0).read(function);
        const Settings settings{125, framing, profile};
        EXPECT_EQ(plan_of(settings, row(static_cast<int>(items), first)).request_count, 1U) << function;
        EXPECT_EQ(plan_of(settings, row(static_cast<int>(items) + 1, first)).request_count, 2U) << function;
    }
}

TEST(Limits, CutEveryGivenLength) {
    const auto items = row(125, int16(0).write(0x10).on_change());
    EXPECT_EQ(spans(plan_of({125, Framing::ascii, Profile::owen_kc1}, items)),
              (std::vector<Span>{{0, 59}, {59, 59}, {118, 7}}));
    EXPECT_EQ(spans(plan_of({125, Framing::rtu, Profile::owen_kc1}, items)),
              (std::vector<Span>{{0, 123}, {123, 2}}));
}

TEST(Limits, CutReadsOfEveryGivenLength) {
    EXPECT_EQ(spans(plan_of({125, Framing::ascii, Profile::owen_kc1}, row(125, int16(0).read(3)))),
              (std::vector<Span>{{0, 61}, {61, 61}, {122, 3}}));
}

TEST(Limits, CountEachBool) {
    const auto coils = bits({{0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}});
    EXPECT_EQ(spans(plan_of({2}, coils)), (std::vector<Span>{{0, 2}, {2, 2}, {4, 1}}));
    std::vector<Item> in_register;
    for (int bit = 0; bit < 5; ++bit) in_register.push_back(boolean(9, bit).read(3));
    EXPECT_EQ(spans(plan_of({2}, in_register)), (std::vector<Span>{{9, 1}, {9, 1}, {9, 1}}));
}

TEST(Limits, NeverSplitAValue) {
    EXPECT_EQ(spans(plan_of({5}, row(4, real(0).read(3)))), (std::vector<Span>{{0, 4}, {4, 4}}));
    EXPECT_EQ(spans(plan_of({2}, row(2, item(DataType::float64, 0).read(3)))),
              (std::vector<Span>{{0, 4}, {4, 4}}))
        << "a value longer than registers per request still goes alone";
}

}  // namespace examples_test
}  // namespace takt::plan
