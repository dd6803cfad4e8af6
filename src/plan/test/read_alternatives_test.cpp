#include "takt/plan/read_alternatives.hpp"

#include <gtest/gtest.h>

#include "builder.hpp"

namespace takt::plan {
namespace read_alternatives_test {

using namespace test;
using Kind = ReadAlternative::Kind;
using wire::Function;

constexpr auto kHolding = Function::read_holding_registers;
constexpr auto kCoils = Function::read_coils;

/// The alternatives to the first request of the first device.
std::vector<ReadAlternative> alternatives(const model::Project& described) {
    const auto made = make_plan(described);
    const auto& line = described.lines[0];
    const AlternativeReads reads(described, line, line.devices[0], made.lines[0].requests);
    const auto found = reads.of(made.lines[0].requests.at(0));
    return {found.begin(), found.end()};
}

TEST(ReadAlternatives, PartsOfAGroupEndWithAVariable) {
    EXPECT_EQ(alternatives(project({}, row(4, real(0).read(3)))),
              (std::vector<ReadAlternative>{
                  {Kind::part, kHolding, 0, 2}, {Kind::part, kHolding, 0, 6}, {Kind::part, kHolding, 0, 7}}));
}

TEST(ReadAlternatives, AValueAloneIsReadInPartAndARegisterAloneHasNone) {
    EXPECT_EQ(alternatives(project({}, {real(0).read(3)})),
              (std::vector<ReadAlternative>{{Kind::part, kHolding, 0, 1}}));
    EXPECT_TRUE(alternatives(project({}, {int16(0).read(3)})).empty());
}

TEST(ReadAlternatives, WiderReadsHaveRegistersThatTheProjectReadsAndKeepTheLimit) {
    // 16 registers per request: two requests, of 16 and of 4.
    EXPECT_EQ(
        alternatives(project({.registers_per_request = 16}, row(20, int16(0).read(3)))),
        (std::vector<ReadAlternative>{
            {Kind::part, kHolding, 0, 1}, {Kind::part, kHolding, 0, 15}, {Kind::another, kHolding, 16, 4}}));
    auto split =
        project({.registers_per_request = 20},
                {int16(0).read(3).every(100ms), int16(1).read(3).every(1s), int16(2).read(3).every(1s)});
    EXPECT_EQ(alternatives(split),
              (std::vector<ReadAlternative>{{Kind::wider, kHolding, 0, 2}, {Kind::wider, kHolding, 0, 3}}));
}

TEST(ReadAlternatives, WithGapsAlwaysWhatIsReadableIsRead) {
    auto described = project({.strategy = model::Strategy::optimal}, {int16(10).read(3)});
    auto& device = described.lines[0].devices[0];
    device.gaps = model::Gaps::always;
    device.readable[static_cast<std::size_t>(wire::Area::holding_register)] = {{9, 11}};
    EXPECT_EQ(alternatives(described),
              (std::vector<ReadAlternative>{{Kind::wider, kHolding, 10, 2}, {Kind::wider, kHolding, 9, 3}}));
}

TEST(ReadAlternatives, BitsNeedAnotherNumberOfBytes) {
    auto described = project({.registers_per_request = 64, .strategy = model::Strategy::optimal},
                             {item(DataType::boolean, 0).read(1)});
    auto& device = described.lines[0].devices[0];
    device.gaps = model::Gaps::always;
    const auto found = alternatives(described);
    ASSERT_EQ(found.size(), 3U);
    EXPECT_EQ(found[0], (ReadAlternative{Kind::wider, kCoils, 0, 9}));
    EXPECT_EQ(found[1], (ReadAlternative{Kind::wider, kCoils, 0, 17}));
}

TEST(ReadAlternatives, InOwenKc1RequestsAreSplitOnly) {
    const auto found = alternatives(
        project({.registers_per_request = 2, .profile = model::Profile::owen_kc1}, row(5, int16(0).read(3))));
    EXPECT_EQ(found, (std::vector<ReadAlternative>{{Kind::part, kHolding, 0, 1}}));
    EXPECT_TRUE(alternatives(project({.profile = model::Profile::owen_kc1}, {real(0).read(3)})).empty())
        << "a value is never read in part";
}

}  // namespace read_alternatives_test
}  // namespace takt::plan
