// Plans with more than one variable per request: phases, shapes, gaps, statuses of each member,
// admission, deadlines.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>

#include "bench.hpp"

namespace takt::poll {
namespace plans_test {

using namespace test;

/// Reads of unit 1 by 0x03 with a period of 300 ms; a case changes what it needs.
plan::Request reading(std::vector<std::size_t> variables, std::uint16_t start, std::uint16_t quantity) {
    plan::Request request;
    request.variables = std::move(variables);
    request.read = Function::read_holding_registers;
    request.start = start;
    request.quantity = quantity;
    request.period = 300ms;
    return request;
}

plan::Plan plan_of(std::vector<plan::Request> requests) {
    plan::Plan plan;
    plan.lines.emplace_back().requests = std::move(requests);
    return plan;
}

std::vector<Duration> times(const std::vector<Sent>& sent, std::uint16_t start) {
    std::vector<Duration> found;
    for (const auto& request : sent)
        if (request.start == start) found.push_back(request.t - at(0ms));
    return found;
}

/// "a" every 100 ms at 0, "b" every 300 ms at 1: read with "a" every third time.
struct Shapes {
    Shapes() {
        described = project({device(1, {int16("a", 0).read(3), int16("b", 2).read(3).every(300ms)})});
        described.lines[0].devices[0].poll_enable = 0;
        auto on = local("on");
        on.default_value = model::Constant{.integer = 1};
        described.locals = {on};
        auto wide = reading({0, 1}, 0, 3);
        auto second = reading({0}, 0, 1);
        second.phase = 100ms;
        auto third = second;
        third.phase = 200ms;
        planned = plan_of({wide, second, third});
    }
    model::Project described;
    plan::Plan planned;
};

TEST(Plans, ShapesTakeTurnsOnTheGridOfTheirLine) {
    Shapes shapes;
    Bench bench(shapes.described, shapes.planned);
    bench.players[1].registers = {{0, 1}, {1, 99}, {2, 3}};
    bench.run_until(1190ms);
    ASSERT_EQ(bench.sent.size(), 12U);
    for (std::size_t i = 1; i < bench.sent.size(); ++i)
        EXPECT_EQ(bench.sent[i].t, at(static_cast<int>(i) * 100ms)) << i;
    EXPECT_EQ(bench.slot("b").value, value::Value(std::int64_t{3}))
        << "the register between is of no account";
    const auto& line = bench.master.line(0);
    EXPECT_FALSE(line.request(1).overrun);
    EXPECT_EQ(line.request(1).real_period.mean(), 300ms);
    EXPECT_EQ(line.variable(0, 0).period, 100ms);
    EXPECT_NEAR(static_cast<double>(line.variable(0, 0).real_period.mean().count()), 100e6, 1e6);
    EXPECT_NEAR(static_cast<double>(line.variable(0, 1).real_period.mean().count()), 300e6, 1e6);
}

TEST(Plans, TheGridSurvivesTheLink) {
    Shapes shapes;
    Bench bench(shapes.described, shapes.planned);
    bench.run_until(130ms);
    bench.link(false);
    bench.run_until(345ms);
    bench.news();
    bench.link(true);
    bench.run_until(844ms);
    const auto sent = bench.news();
    ASSERT_EQ(sent.size(), 7U);
    EXPECT_LT(sent[0].t, at(350ms)) << "overdue";
    EXPECT_EQ(sent[0].bytes.substr(6, 11), "00 00 00 01");
    EXPECT_LT(sent[1].t, at(360ms)) << "overdue";
    for (std::size_t i = 2; i < 7; ++i) EXPECT_EQ(sent[i].t, at(static_cast<int>(i + 2) * 100ms));
    for (const std::size_t i : {1U, 4U}) EXPECT_EQ(sent[i].bytes.substr(6, 11), "00 00 00 03");
}

TEST(Plans, ADeviceThatComesBackIsReadAtOnceAndThenOnTheGrid) {
    Shapes shapes;
    Bench bench(shapes.described, shapes.planned);
    bench.run_until(130ms);
    ASSERT_TRUE(bench.set("on", false));
    bench.run_until(440ms);
    bench.news();
    ASSERT_TRUE(bench.set("on", true));
    bench.run_until(790ms);
    const auto sent = bench.news();
    ASSERT_EQ(sent.size(), 4U);
    EXPECT_EQ(sent[0].t, at(440ms)) << "what covers all its variables";
    EXPECT_EQ(sent[0].bytes.substr(6, 11), "00 00 00 03");
    EXPECT_EQ(sent[1].t, at(500ms));
    EXPECT_EQ(sent[2].t, at(600ms));
    EXPECT_EQ(sent[3].t, at(700ms));
    EXPECT_EQ(sent[2].bytes.substr(6, 11), "00 00 00 03");
}

TEST(Plans, EachMemberReportsToItsOwnStatus) {
    auto described = project({device(1, {int16("a", 0).read(3).reports_to(0),
                                         int16("b", 1).read(3).reports_to(1), int16("c", 2).read(3)})},
                             {local("sa", DataType::int16), local("sb", DataType::int16)});
    Bench bench(described, plan_of({reading({0, 1, 2}, 0, 3)}));
    bench.players[1].exception = 2;
    bench.run_until(100ms);
    EXPECT_EQ(bench.status("sa"), 2);
    EXPECT_EQ(bench.status("sb"), 2);
    bench.players[1].exception.reset();
    bench.run_until(400ms);
    EXPECT_EQ(bench.status("sa"), 0);
    EXPECT_EQ(bench.status("sb"), 0);
    bench.players[1].dead = true;
    bench.run_until(3s);
    EXPECT_EQ(bench.status("sa"), 105);
    EXPECT_EQ(bench.status("sb"), 105);
}

// ---- admission

Bench admitted_bench(const Item& item, const model::Local& go = local("go")) {
    auto described = project({device(1, {item})}, {go});
    return Bench(described);
}

TEST(Admission, ABurstAndThenOneEachInterval) {
    auto bench = admitted_bench(int16("v", 0).write(0x06).on_change().admitted(100ms, 2));
    // a change each 10 ms for a second
    for (int i = 0; i < 100; ++i) {
        ASSERT_TRUE(bench.set("v", std::int64_t{i}));
        bench.run_until((i + 1) * 10ms);
    }
    const auto sent = times(bench.sent, 0);
    ASSERT_EQ(sent.size(), 12U);
    EXPECT_LT(sent[1], 20ms);
    for (std::size_t i = 2; i < sent.size(); ++i) EXPECT_EQ(sent[i], static_cast<int>(i - 1) * 100ms) << i;
    bench.run_until(1200ms);
    EXPECT_EQ(bench.players[1].registers[0], 99) << "the last one is not lost";
}

TEST(Admission, CommandsOfTheGroupPassTheSameBucket) {
    auto bench = admitted_bench(int16("v", 0).write(0x06).on_change().admitted(100ms, 1));
    bench.run_until(5ms);
    for (int i = 1; i <= 5; ++i) {
        ASSERT_TRUE(bench.write(static_cast<value::CommandId>(i), "v", std::int64_t{i}));
        bench.run_until(5ms + i * 10ms);
    }
    EXPECT_EQ(bench.sent.size(), 1U);
    bench.run_until(200ms);
    ASSERT_EQ(bench.sent.size(), 2U) << "those that waited go together";
    EXPECT_EQ(bench.sent[1].t - bench.sent[0].t, 100ms);
    EXPECT_EQ(bench.outcomes.size(), 5U);
    EXPECT_EQ(bench.players[1].registers[0], 5);
}

TEST(Admission, TriggersAndCommandsBesideThemToo) {
    auto go = local("go");
    go.admission = model::RateLimit{100ms, 1};
    for (const bool reads : {true, false}) {
        auto bench = admitted_bench(
            reads ? int16("v", 0).read(3).every(24h).read_on(0) : int16("v", 0).write(0x06).write_on(0), go);
        if (!reads) {
            ASSERT_TRUE(bench.set("v", std::int64_t{1}));
        }
        bench.run_until(20ms);
        bench.news();
        for (int i = 0; i < 30; ++i) {
            ASSERT_TRUE(bench.set("go", true));
            ASSERT_TRUE(bench.set("go", false));
            if (!reads) {
                ASSERT_TRUE(bench.write(static_cast<value::CommandId>(i), "v", std::int64_t{i}, 1h));
            }
            bench.run_until(20ms + (i + 1) * 10ms);
        }
        const auto sent = bench.news();
        ASSERT_GE(sent.size(), 3U);
        for (std::size_t i = 1; i < sent.size(); ++i) EXPECT_GE(sent[i].t - sent[i - 1].t, 99ms) << reads;
    }
}

TEST(Admission, ARepeatedAttemptNeedsNoNewOne) {
    auto bench = admitted_bench(int16("v", 0).write(0x06).on_change().repeatable().admitted(10s, 1));
    bench.players[1].dead = true;
    ASSERT_TRUE(bench.set("v", std::int64_t{1}));
    bench.run_until(150ms);
    bench.players[1].dead = false;
    bench.run_until(1s);
    EXPECT_EQ(bench.players[1].registers[0], 1);
}

RC_GTEST_PROP(Admission, NeverMoreThanItsBoundAndTheLastValueArrives, ()) {
    const int burst = *rc::gen::inRange(1, 4);
    auto bench = admitted_bench(int16("v", 0).write(0x06).on_change().admitted(50ms, burst));
    Duration end{};
    std::int64_t last = 0;
    const int changes = *rc::gen::inRange(1, 40);
    for (int i = 1; i <= changes; ++i) {
        RC_ASSERT(bench.set("v", std::int64_t{i}).has_value());
        last = i;
        end += *rc::gen::inRange(0, 60) * 1ms;
        bench.run_until(end);
    }
    bench.run_until(end + 10s);
    RC_ASSERT(bench.players[1].registers[0] == last);
    const auto sent = times(bench.sent, 0);
    // From admission to the line at most one transaction, which takes less than 10 ms.
    for (std::size_t i = 0; i < sent.size(); ++i)
        for (std::size_t k = i; k < sent.size(); ++k)
            RC_ASSERT(static_cast<std::int64_t>(k - i + 1) <= burst + (sent[k] - sent[i] + 10ms) / 50ms);
}

// ---- priorities (docs/guarantees.md, "Fixed priority without preemption")

TEST(Priorities, WhatIsAdmittedGoesByDeadlineBeforeWhatHasNoBound) {
    auto slow = int16("slow", 0).write(0x06).on_change().admitted(1s, 1);
    slow.deadline = 80ms;
    auto fast = int16("fast", 5).write(0x06).on_change().admitted(1s, 1);
    fast.deadline = 20ms;
    auto tied = int16("tied", 3).write(0x06).on_change().admitted(1s, 1);
    tied.deadline = 80ms;
    auto free = int16("free", 8).write(0x06).on_change();
    Bench bench(
        project({device(2, {slow, fast, tied, free}), device(1, {int16("polled", 0).read(3).every(10ms)})}));
    bench.run_until(2ms);  // the polling is on its way
    bench.news();
    for (const char* name : {"free", "tied", "slow", "fast"}) ASSERT_TRUE(bench.set(name, std::int64_t{1}));
    bench.run_until(60ms);
    std::vector<int> order;
    for (const auto& request : bench.news())
        if (request.unit == 2) order.push_back(request.start);
    EXPECT_EQ(order, (std::vector<int>{5, 0, 3, 8}));
}

TEST(Priorities, TheDeadlineOfPollingIsNotThatOfTheCommand) {
    auto polled = int16("polled", 0).read(3).every(10ms).write(0x06).on_change().admitted(1s, 1);
    auto urgent = int16("urgent", 5).write(0x06).on_change().admitted(2s, 1);
    urgent.deadline = 500ms;
    Bench bench(project({device(1, {polled, urgent})}));
    bench.run_until(12ms);  // a read is on its way
    bench.news();
    for (const char* name : {"polled", "urgent"}) ASSERT_TRUE(bench.set(name, std::int64_t{1}));
    bench.run_until(60ms);
    std::vector<int> order;
    for (const auto& request : bench.news())
        if (request.function == 6) order.push_back(request.start);
    EXPECT_EQ(order, (std::vector<int>{5, 0}));
}

TEST(Priorities, PollingGoesByTheDeadlineOfTheRequest) {
    auto described =
        project({device(1, {int16("a", 0).read(3), int16("b", 10).read(3), int16("c", 20).read(3)})});
    auto a = reading({0}, 0, 1), b = reading({1}, 10, 1), c = reading({2}, 20, 1);
    a.deadline = 200ms;
    b.deadline = 100ms;
    c.deadline = 100ms;
    Bench bench(described, plan_of({a, b, c}));
    bench.run_until(100ms);
    std::vector<int> order;
    for (const auto& request : bench.sent) order.push_back(request.start);
    EXPECT_EQ(order, (std::vector<int>{10, 20, 0}));
}

// A line that can hold its periods keeps the order of the deadlines, also while faults make it late.
TEST(Priorities, LatenessByFaultsDoesNotTurnThePrioritiesRound) {
    auto described =
        project({device(1, {int16("urgent", 0).read(3)}), device(2, {int16("patient", 0).read(3)}),
                 device(3, {int16("dying", 0).read(3)})});
    for (auto& device : described.lines[0].devices) device.response_timeout = 60ms;
    auto urgent = reading({0}, 0, 1), patient = reading({0}, 0, 1), dying = reading({0}, 0, 1);
    urgent.period = urgent.deadline = 20ms;
    patient.device = 1;
    patient.period = 100ms;
    patient.deadline = 30ms;
    dying.device = 2;
    dying.period = 200ms;
    dying.deadline = 10ms;
    Bench bench(described, plan_of({urgent, patient, dying}));
    bench.players[3].dead = true;
    bench.run_until(400ms);
    ASSERT_GE(bench.sent.size(), 4U);
    EXPECT_EQ(bench.sent[0].unit, 3);
    // Both have waited beyond their deadlines: the more urgent one first all the same.
    const auto first =
        std::find_if(bench.sent.begin(), bench.sent.end(), [](const Sent& s) { return s.unit != 3; });
    EXPECT_EQ(first->unit, 1);
    EXPECT_EQ((first + 1)->unit, 2);
}

TEST(Plans, TheBackOffIsTheDevicesElseTheProjects) {
    for (const bool own : {true, false}) {
        auto described = project({device(1, {int16("a", 0).read(3)})});
        described.backoff = {100ms, 200ms};
        if (own) described.lines[0].devices[0].backoff = model::Backoff{3s, 3s};
        // No room for probes before their back-off: device 2 is asked again before one has timed out.
        described.lines[0].devices.push_back(device(2, {int16("b", 0).read(3).every(50ms)}));
        Bench bench(described);
        bench.players[1].dead = true;
        bench.run_until(10s);
        const auto sent = std::ranges::count(bench.sent, 1, &Sent::unit);
        if (own)
            EXPECT_LT(sent, 8);
        else
            EXPECT_GT(sent, 25);
    }
}

}  // namespace plans_test
}  // namespace takt::poll
