// Values longer than a request are shown whole or not at all.
#include "reads/split.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "bench.hpp"

namespace takt::poll {
namespace split_test {

using namespace test;

// ---- putting together

struct Step {
    std::size_t request;
    std::optional<std::int64_t> round;
    bool whole;
};
struct Case {
    const char* what;
    std::vector<Step> steps;
};

const Case kCases[] = {
    {"one round", {{0, 1, false}, {1, 1, true}}},
    {"the other way round", {{1, 1, false}, {0, 1, true}}},
    {"a part of the round before", {{0, 1, false}, {1, 2, false}, {0, 2, true}}},
    {"the first part failed once", {{1, 1, false}, {0, 2, false}, {1, 2, true}}},
    {"a part twice in its round", {{0, 1, false}, {0, 1, false}, {1, 1, true}}},
    {"a trigger between", {{0, 1, false}, {1, -1, false}, {0, -1, true}}},
    {"in turn", {{0, {}, false}, {1, {}, true}}},
    {"in turn, the second failed", {{0, {}, false}, {0, {}, false}, {1, {}, true}}},
};

TEST(SplitValue, NeedsAllPartsOfOneRound) {
    for (const auto& [what, steps] : kCases) {
        SplitValue value(5);
        value.add_part(0, 0, 3);
        value.add_part(1, 3, 2);
        std::uint16_t stamp = 0;
        for (const auto& [request, round, whole] : steps) {
            ++stamp;
            const std::vector<std::uint16_t> registers(request == 0 ? 3 : 2, stamp);
            value.take(request, round, registers, Instant{} + Duration(stamp));
            EXPECT_EQ(value.whole().has_value(), whole) << what;
        }
        const auto whole = *value.whole();
        EXPECT_EQ(whole.size(), 5U);
        const bool second_last = steps.back().request == 1;
        EXPECT_EQ(whole[second_last ? 4 : 0], stamp) << what;
        EXPECT_EQ(whole[second_last ? 0 : 4], stamp - 1) << what;
        value.forget();
        EXPECT_FALSE(value.whole());
    }
}

// ---- on the line

/// A string of ten registers, read five by five, and one register behind it.
struct Setup {
    model::Project project;
    plan::Plan plan;
};

Setup setup(Duration period, Duration second_phase = 0ms) {
    auto text = item("text", DataType::string, 0).read(3).every(period);
    text.registers = 10;
    Setup made{project({device(1, {text, int16("next", 10).read(3).every(period)})}), {}};
    auto& line = made.plan.lines.emplace_back();
    for (int part = 0; part < 2; ++part) {
        auto& request = line.requests.emplace_back();
        request.variables = part == 0 ? std::vector<std::size_t>{0} : std::vector<std::size_t>{0, 1};
        request.read = Function::read_holding_registers;
        request.start = static_cast<std::uint16_t>(5 * part);
        request.quantity = part == 0 ? 5 : 6;
        request.period = period;
        request.phase = part == 0 ? 0ms : second_phase;
    }
    return made;
}

void fill(Player& player, char letter) {
    for (std::uint16_t i = 0; i < 10; ++i)
        player.registers[i] = static_cast<std::uint16_t>(letter << 8 | letter);
}

bool is_whole(const value::Value& value) {
    const auto* text = std::get_if<std::string>(&value);
    return text && text->size() == 20 && text->find_first_not_of(text->front()) == std::string::npos;
}

TEST(SplitValue, IsShownWhenItsLastPartHasCome) {
    auto [described, plan] = setup(100ms, 50ms);
    Bench bench(described, plan);
    fill(bench.players[1], 'a');
    bench.players[1].registers[10] = 7;
    bench.run_until(40ms);
    EXPECT_EQ(bench.slot("text").quality, value::Quality::never_read);
    bench.run_until(90ms);
    EXPECT_EQ(bench.slot("text").value, value::Value(std::string(20, 'a')));
    EXPECT_EQ(bench.slot("text").batch, bench.slot("next").batch);
    EXPECT_EQ(bench.slot("next").value, value::Value(std::int64_t{7}));
    fill(bench.players[1], 'b');
    bench.run_until(140ms);
    EXPECT_EQ(bench.slot("text").value, value::Value(std::string(20, 'a')));
    bench.run_until(190ms);
    EXPECT_EQ(bench.slot("text").value, value::Value(std::string(20, 'b')));
}

TEST(SplitValue, APartThatFailsHoldsTheValueBack) {
    auto [described, plan] = setup(100ms);
    described.lines[0].devices[0].attempts = 100;
    Bench bench(described, plan);
    fill(bench.players[1], 'a');
    bench.run_until(90ms);
    bench.players[1].silent_to = [](const wire::Request& request) {
        const auto& read = std::get<wire::ReadRequest>(request);
        return read.start.value + read.quantity > 5;
    };
    fill(bench.players[1], 'b');
    bench.run_until(1s);
    EXPECT_EQ(bench.slot("text").value, value::Value(std::string(20, 'a')));
    EXPECT_NE(bench.slot("text").quality, value::Quality::good);
    bench.players[1].silent_to = {};
    bench.run_until(2s);
    EXPECT_EQ(bench.slot("text").value, value::Value(std::string(20, 'b')));
    EXPECT_EQ(bench.slot("text").quality, value::Quality::good);
}

TEST(SplitValue, AsFastAsTheLineAllows) {
    auto [described, plan] = setup(0ms);
    Bench bench(described, plan);
    fill(bench.players[1], 'a');
    bench.run_until(100ms);
    EXPECT_TRUE(is_whole(bench.slot("text").value));
    EXPECT_GT(bench.master.line(0).variable(0, 0).real_period.count(), 3U);
}

// The device changes the value between rounds only, so a mixture could only come from parts of two rounds.
RC_GTEST_PROP(SplitValue, IsNeverTornByFailures, ()) {
    auto [described, plan] = setup(100ms, *rc::gen::inRange(0, 90) * 1ms);
    Bench bench(described, plan);
    auto& player = bench.players[1];
    for (int round = 0; round < 30; ++round) {
        const bool idle = bench.sent.empty() || bench.sent.back().t < at(round * 100ms - 30ms);
        if (idle) fill(player, static_cast<char>('a' + round % 26));
        player.dead = *rc::gen::inRange(0, 6) == 0;
        player.silent_about.clear();
        if (*rc::gen::inRange(0, 4) == 0) player.silent_about = {*rc::gen::element<std::uint16_t>(0, 5)};
        player.turnaround = *rc::gen::inRange(1, 12) * 1ms;
        bench.run_until(round * 100ms + 99ms);
        const auto& slot = bench.slot("text");
        RC_ASSERT(value::is_empty(slot.value) || is_whole(slot.value));
    }
}

TEST(SplitValues, AreFoundByTheirVariable) {
    SplitValues values;
    EXPECT_FALSE(values.has(0));
    EXPECT_EQ(values.find(7), nullptr);
    values.forget(7);
    values.add_part(3, 4, 10, 0, 2);
    values.add_part(1, 2, 10, 0, 1);
    values.add_part(3, 4, 11, 2, 2);
    EXPECT_FALSE(values.has(0));
    EXPECT_FALSE(values.has(2));
    ASSERT_TRUE(values.has(3));
    ASSERT_NE(values.find(3)->part_of(11), nullptr);
    EXPECT_EQ(values.find(3)->part_of(11)->first, 2U);
    EXPECT_EQ(values.find(1)->part_of(11), nullptr);
    const std::uint16_t kPart[] = {7, 8};
    values.find(3)->take(10, 1, kPart, Instant{});
    values.forget(3);
    values.find(3)->take(11, 1, kPart, Instant{});
    EXPECT_FALSE(values.find(3)->whole()) << "the first part was forgotten";
    values.find(3)->take(10, 1, kPart, Instant{});
    EXPECT_TRUE(values.find(3)->whole());
    values.clear();
    EXPECT_FALSE(values.has(3));
}

}  // namespace split_test
}  // namespace takt::poll
