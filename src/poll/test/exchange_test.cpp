// 0x17: written and read at once, by a trigger.
#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll {
namespace exchange_test {

using namespace test;
using Pdus = std::vector<std::string>;

Pdus pdus(Bench& bench) {
    Pdus sent;
    for (const auto& request : bench.news())
        sent.push_back(request.bytes.substr(3, request.bytes.size() - 9));
    return sent;
}

/// Reads "in" at 0 and "back" at 11, writes "out" at 10 and "back" at 11, all by the local "go".
struct Setup {
    model::Project project;
    plan::Plan plan;
};

Setup setup(bool on_change = false) {
    auto out = int16("out", 10).write(0x10).write_on(0);
    auto back = int16("back", 11).read(3).read_on(0).write(0x10).write_on(0);
    if (on_change) out = out.on_change(), back = back.on_change();
    auto described = device(1, {int16("in", 0).read(3).read_on(0), out, back});
    described.fc23 = true;
    described.status = 1;
    Setup made{project({described}, {local("go"), local("status", DataType::int16)}), {}};
    auto& request = made.plan.lines.emplace_back().requests.emplace_back();
    request.variables = {0, 1, 2};
    request.read = request.write = Function::read_write_multiple_registers;
    request.start = 0;
    request.quantity = 12;
    request.write_start = 10;
    request.write_quantity = 2;
    request.read_trigger = request.write_trigger = 0;
    request.write_on_change = on_change;
    return made;
}

TEST(Exchange, OneRequestWritesAndThenReads) {
    auto [described, plan] = setup();
    Bench bench(described, plan);
    bench.players[1].registers = {{0, 42}, {10, 1}, {11, 2}};
    ASSERT_TRUE(bench.set("out", std::int64_t{5}));
    ASSERT_TRUE(bench.set("back", std::int64_t{6}));
    bench.run_until(50ms);
    EXPECT_TRUE(pdus(bench).empty());
    ASSERT_TRUE(bench.set("go", true));
    bench.run_until(100ms);
    EXPECT_EQ(pdus(bench), Pdus{"17 00 00 00 0C 00 0A 00 02 04 00 05 00 06"});
    EXPECT_EQ(bench.slot("in").value, value::Value(std::int64_t{42}));
    EXPECT_EQ(bench.slot("back").value, value::Value(std::int64_t{6}));
    EXPECT_EQ(bench.slot("out").value, value::Value(std::int64_t{5}));
    EXPECT_EQ(bench.slot("back").quality, value::Quality::good);
    bench.run_until(1s);
    EXPECT_TRUE(pdus(bench).empty()) << "once for each trigger";
}

TEST(Exchange, WhereTheWriteHasToWaitTheReadGoesAlone) {
    auto [described, plan] = setup();
    Bench bench(described, plan);
    bench.players[1].registers = {{0, 42}, {11, 2}};
    ASSERT_TRUE(bench.set("go", true));
    bench.run_until(50ms);
    EXPECT_EQ(pdus(bench), Pdus{"03 00 00 00 0C"});
    EXPECT_EQ(bench.slot("in").value, value::Value(std::int64_t{42}));
    EXPECT_EQ(bench.observed.waiting, std::vector<std::size_t>{1});
    ASSERT_TRUE(bench.set("out", std::int64_t{5}));
    bench.run_until(100ms);
    EXPECT_EQ(pdus(bench), Pdus{"17 00 00 00 0C 00 0A 00 02 04 00 05 00 02"});  // "back" as it was read
}

TEST(Exchange, AnExceptionAndSilenceAreReported) {
    for (const bool silent : {false, true}) {
        auto [described, plan] = setup(true);
        Bench bench(described, plan);
        if (silent)
            bench.players[1].ignores_writes = true;
        else
            bench.players[1].exception = 2;
        ASSERT_TRUE(bench.set("back", std::int64_t{6}));
        ASSERT_TRUE(bench.write(1, "out", std::int64_t{5}));
        bench.run_until(90ms);
        if (silent) {
            bench.run_until(1s);
            ASSERT_EQ(bench.outcomes.size(), 1U);
            EXPECT_EQ(bench.outcomes[0].result, value::CommandResult::unknown);
            EXPECT_EQ(bench.status("status"), 100);
            EXPECT_EQ(bench.sent.size(), 1U) << "whether it was written is not known";
        } else {
            ASSERT_EQ(bench.outcomes.size(), 1U);
            EXPECT_EQ(bench.outcomes[0].result, value::CommandResult::refused);
            EXPECT_EQ(bench.status("status"), 2);
        }
    }
}

TEST(Exchange, ProbesDoNotWrite) {
    auto [described, plan] = setup();
    Bench bench(described, plan);
    bench.players[1].registers = {{10, 1}, {11, 2}};
    ASSERT_TRUE(bench.set("out", std::int64_t{5}));
    ASSERT_TRUE(bench.set("back", std::int64_t{6}));
    bench.players[1].dead = true;
    for (int i = 0; i < 3; ++i) {
        ASSERT_TRUE(bench.set("go", true));
        ASSERT_TRUE(bench.set("go", false));
        bench.run_until((i + 1) * 500ms);
    }
    bench.news();
    bench.run_until(4s);
    const auto probes = pdus(bench);
    ASSERT_FALSE(probes.empty());
    // The range that 0x17 reads, or a part of it while responses of that length are outstanding.
    const Pdus allowed = {"03 00 00 00 0C", "03 00 00 00 01", "03 00 0B 00 01"};
    for (const auto& pdu : probes) EXPECT_TRUE(std::ranges::find(allowed, pdu) != allowed.end()) << pdu;
    EXPECT_TRUE(std::ranges::find(probes, allowed[0]) != probes.end());
}

}  // namespace exchange_test
}  // namespace takt::poll
