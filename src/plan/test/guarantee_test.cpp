#include "takt/plan/guarantee.hpp"

#include <gtest/gtest.h>

#include "golden_project.hpp"

namespace takt::plan {
namespace guarantee_test {

using namespace test;

// The golden sets as projects
// ---------------------------------------------------------------------------------

/// Of the request of a device that takes longest.
Bound last_of(const LinePlan& plan, const LineGuarantee& guarantee, std::size_t device) {
    Bound last;
    for (std::size_t i = 0; i < guarantee.requests.size(); ++i)
        if (plan.requests[i].device == device && guarantee.requests[i].response > last.response)
            last = guarantee.requests[i];
    return last;
}

TEST(Guarantee, GoldenSetsAsProjects) {
    for (const auto& set : golden::sets()) {
        const auto project = project_of(set);
        const Plan plan = make_plan(project);
        const auto made = guarantee(project, plan).at(0);
        for (std::size_t i = 0; i < set.rows.size(); ++i) {
            SCOPED_TRACE(std::string(set.name) + ": " + set.rows[i].name);
            const auto& row = set.rows[i];
            const Bound bound = last_of(plan.lines[0], made, i);
            EXPECT_EQ(bound.transaction, std::chrono::microseconds(row.frames.front()));
            EXPECT_EQ(bound.failure, std::chrono::microseconds(row.failure));
            EXPECT_EQ(bound.response, std::chrono::microseconds(row.response));
            EXPECT_EQ(bound.response_with_fault, std::chrono::microseconds(row.response_with_fault));
            EXPECT_EQ(bound.response_with_dead, std::chrono::microseconds(row.response_with_dead));
            EXPECT_EQ(bound.deadline, std::chrono::microseconds(row.deadline));
            EXPECT_TRUE(mentions(row, "FC6") ||
                        bound.age == std::chrono::microseconds(row.period + row.response));
        }
        EXPECT_NEAR(made.utilization, set.utilization, 1e-6) << set.name;
        EXPECT_EQ(made.feasible_edf, set.edf) << set.name;
        EXPECT_EQ(made.feasible,
                  std::all_of(set.rows.begin(), set.rows.end(), [](auto& row) { return row.ok; }))
            << set.name;
        EXPECT_EQ(made.unlimited, 0U);
    }
}

// C and F
// -----------------------------------------------------------------------------------------------------

Bound only(const model::Project& project) {
    return guarantee(project, make_plan(project)).at(0).requests.at(0);
}

// 115200 8N1, a longest frame of 256 characters 22 222.2 us, response timeout 20 ms, margin 2 ms, t3.5 1750,
// overhead 200: the time-out is 44 223, a relayed transaction takes up to 68 396 us; a broadcast 124 173. One
// blocks, and one goes ahead when an interval has passed since the end of the last.
TEST(Guarantee, RequestsOfOthersBlockOnceAndGoAheadOnceAnInterval) {
    model::Project project;
    model::Line& line = project.lines.emplace_back();
    line.format = {115200, 8, wire::Parity::none, 1};
    model::Device& device = line.devices.emplace_back();
    device.response_timeout = 20ms;
    device.turnaround = 3ms;
    model::Variable& variable = device.variables.emplace_back();
    variable.read = wire::Function::read_holding_registers;
    variable.period = 1s;
    const auto alone = only(project);
    line.relayed = model::SharedLine{20ms, false};
    line.relay_interval = 1s;
    const auto shared = guarantee(project, make_plan(project)).at(0);
    EXPECT_EQ(*shared.requests[0].response - *alone.response, 2 * 68'396us);
    EXPECT_NEAR(shared.utilization,
                static_cast<double>(alone.transaction.count()) / 1e9 + 0.068396 / (0.9998 + 0.068396), 1e-6);
    line.relay_interval = 100ms;
    EXPECT_EQ(*only(project).response - *alone.response, 3 * 68'396us);
    line.relayed->broadcast = true;
    line.relay_interval = 1s;
    EXPECT_EQ(*only(project).response - *alone.response, 2 * 124'173us);
    line.relay_interval = 50ms;
    line.relayed->broadcast = false;
    EXPECT_EQ(*only(project).response - *alone.response, 4 * 68'396us);
    line.relay_interval = 1ms;
    EXPECT_GT(*only(project).response, 1s) << "they leave 1 ms after each";
}

// 19200 8E1: a character takes 572.92 us, t3.5 2005.21 us. A write of one register: 8 + 8 characters 9166.67,
// turnaround 3000, silence 2005.21, overhead 200 = 14 372 us; reading it back 8 + 7 characters: 13 799 us.
TEST(Guarantee, CommandsOfClientsBlockOnceAndGoAheadOnceAnInterval) {
    model::Project project;
    model::Line& line = project.lines.emplace_back();
    line.format = {19200, 8, wire::Parity::even, 1};
    model::Device& device = line.devices.emplace_back();
    device.turnaround = 3ms;
    model::Variable& variable = device.variables.emplace_back();
    variable.read = wire::Function::read_holding_registers;
    variable.write = wire::Function::write_single_register;
    variable.period = 1s;
    const auto alone = only(project);
    variable.written_by_clients = true;
    EXPECT_EQ(*only(project).response - *alone.response, 2 * 14'372us);
    line.commands.burst = 3;
    EXPECT_EQ(*only(project).response - *alone.response, 4 * 14'372us);
    line.commands = {.min_interval = 10ms, .burst = 1};
    EXPECT_EQ(*only(project).response - *alone.response, 4 * 14'372us) << "10 ms after the end of each";
    line.commands.min_interval = 250ms;
    variable.verify = true;
    EXPECT_EQ(*only(project).response - *alone.response, 2 * (14'372us + 13'799us));
    const auto shared = guarantee(project, make_plan(project)).at(0);
    EXPECT_NEAR(shared.utilization,
                static_cast<double>(alone.transaction.count()) / 1e9 + 0.028171 / (0.2498 + 0.028171), 1e-6);
    variable.verify = false;
    variable.write_on_change = true;
    EXPECT_EQ(*only(project).response - *alone.response, 2 * 14'372us) << "with its group";
    variable.admission = model::RateLimit{.min_interval = 1s, .burst = 1};
    EXPECT_EQ(*only(project).response - *alone.response, 14'372us) << "a task of its own, at its own rate";
}

struct CostCase {
    const char* arithmetic;
    wire::Framing framing;
    std::optional<Duration> turnaround;
    Duration frame_gap, request_gap;
    std::int64_t transaction_us, failure_us;
};

// One register read with 0x03 at 9600 8E1 (ASCII 7E1), response timeout 80 ms, margin 2 ms, overhead 200 us.
const CostCase kCosts[] = {
    {"8 + 7 characters of 11 bits, twice 38.5 bits, 200 us = 25 408.33; the time-out is 4010.42 + 8020.83 + "
     "2000, up to 14 032, after it 9166.67 + 4010.42 + 200",
     wire::Framing::rtu, 2ms, 0ms, 0ms, 25'409, 27'410},
    {"an unknown turnaround is the response timeout", wire::Framing::rtu, std::nullopt, 0ms, 0ms,
     9'167 + 80'000 + 8'021 + 4'011 + 200 - 1, 9'167 + 90'021 + 4'011 + 200},
    {"a longer gap instead of t3.5", wire::Framing::rtu, 10ms, 5ms, 0ms,
     9'167 + 10'000 + 8'021 + 5'000 + 200 - 0, 9'167 + 20'021 + 5'000 + 200},
    {"stretched", wire::Framing::rtu, 10ms, 5ms, 60ms, 60'000, 60'000},
    {"ASCII: 17 + 15 characters of 10 bits", wire::Framing::ascii, 2ms, 0ms, 0ms, 33'333 + 2'000 + 200 + 1,
     17'708 + 19'625 + 200 + 1},
    {"TCP: 12 + 11 bytes of 10 ns", wire::Framing::tcp, 2ms, 0ms, 0ms, 2'201, 4'202},
};

TEST(Guarantee, CostOfATransactionAndOfAFailure) {
    for (const auto& cost : kCosts) {
        auto made = project({.framing = cost.framing}, {int16(0).read(3)});
        model::Line& line = made.lines.front();
        if (cost.framing == wire::Framing::rtu) line.format = {9600, 8, wire::Parity::even, 1};
        if (cost.framing == wire::Framing::ascii) line.format = {9600, 7, wire::Parity::even, 1};
        line.frame_gap = cost.frame_gap;
        line.request_gap = cost.request_gap;
        line.devices.front().turnaround = cost.turnaround;
        line.devices.front().response_timeout = 80ms;
        EXPECT_EQ(only(made).transaction, std::chrono::microseconds(cost.transaction_us)) << cost.arithmetic;
        EXPECT_EQ(only(made).failure, std::chrono::microseconds(cost.failure_us)) << cost.arithmetic;
    }
}

TEST(Guarantee, AWriteThatOnlyCommandsCauseHasACostAndNoBound) {
    const auto commanded = project({.strategy = model::Strategy::single}, {int16(0).write(0x10)});
    const auto changed = project({.strategy = model::Strategy::single}, {int16(0).write(0x10).on_change()});
    EXPECT_GT(only(commanded).transaction, 0ns);
    EXPECT_EQ(only(commanded).transaction, only(changed).transaction);
    EXPECT_EQ(only(commanded).failure, only(changed).failure);
    EXPECT_FALSE(only(commanded).response);
}

TEST(Guarantee, DerivedTimeoutsCanBeSwitchedOff) {
    auto made = project({}, {int16(0).read(3)});
    made.lines[0].devices[0].turnaround = 5ms;
    const Bound derived = only(made);
    made.derive_timeouts = false;
    EXPECT_EQ(only(made).transaction, derived.transaction);
    EXPECT_EQ(only(made).failure - derived.failure, 495ms);  // 500 ms instead of 5
    made.derive_timeouts = true;
    made.lines[0].devices[0].response_timeout_set = true;
    EXPECT_EQ(only(made).failure - derived.failure, 495ms) << "what is written counts";
}

// Tasks
// -------------------------------------------------------------------------------------------------------

model::Project known(std::vector<Item> items, const Settings& settings = {}) {
    auto made = project(settings, items);
    made.lines[0].devices[0].turnaround = 5ms;
    return made;
}

TEST(Guarantee, EqualDeadlinesAreOrderedByPlaceUnlessTheLineGoesInRounds) {
    auto made = known({real(0).read(3), int16(10).read(3), int16(20).read(3)});
    const auto apart = guarantee(made, make_plan(made)).at(0);
    EXPECT_LT(apart.requests[0].response, apart.requests[1].response);
    EXPECT_LT(apart.requests[1].response, *apart.requests[2].response + 1us);
    made.lines[0].order = model::PollOrder::address;
    const auto rounds = guarantee(made, make_plan(made)).at(0);
    EXPECT_EQ(rounds.requests[0].response, rounds.requests[1].response);
    EXPECT_EQ(rounds.requests[1].response, rounds.requests[2].response);
}

TEST(Guarantee, DeadlineIsTheLeastExplicitOneElseThePeriod) {
    Item strict = int16(1).read(3);
    strict.deadline = 30ms;
    const auto made = known({int16(0).read(3), strict, real(20).read(3).every(700ms)});
    const auto bounds = guarantee(made, make_plan(made)).at(0).requests;
    EXPECT_EQ(bounds.at(0).deadline, 30ms);
    EXPECT_EQ(bounds.at(1).deadline, 700ms);
    EXPECT_EQ(bounds.at(1).age, 700ms + *bounds.at(1).response);
}

TEST(Guarantee, PollingAsFastAsPossibleHasNoBoundAndOnlyBlocks) {
    const auto made = known({int16(0).read(3), row(16, int16(100).read(3).every(0ms))[0].every(0ms)});
    const auto line = guarantee(made, make_plan(made)).at(0);
    EXPECT_TRUE(line.requests.at(0).response);
    EXPECT_FALSE(line.requests.at(1).response);
    EXPECT_FALSE(line.requests.at(1).deadline);
    EXPECT_FALSE(line.requests.at(1).age);
    EXPECT_TRUE(line.feasible);
    EXPECT_EQ(line.unlimited, 0U);
    const Duration hold = line.requests[1].transaction;
    EXPECT_EQ(*line.requests[0].response,
              line.requests[1].transaction + hold + line.requests[0].transaction + 1ms);
}

TEST(Guarantee, RequestsWithoutARateLimitAreLeftOutAndReported) {
    auto made = known({int16(0).read(3)});
    const auto alone = guarantee(made, make_plan(made)).at(0);
    made.locals.push_back({.name = "go"});
    made.lines[0].devices[0].variables.push_back(int16(50).write(0x10).write_on(0).named("w"));
    const auto unlimited = guarantee(made, make_plan(made)).at(0);
    EXPECT_EQ(unlimited.requests.at(0).response, alone.requests.at(0).response);
    EXPECT_FALSE(unlimited.requests.at(1).response);
    EXPECT_EQ(unlimited.unlimited, 1U);
    made.locals[0].admission = model::RateLimit{.min_interval = 1s, .burst = 3};
    const auto limited = guarantee(made, make_plan(made)).at(0);
    EXPECT_EQ(limited.unlimited, 0U);
    EXPECT_EQ(limited.requests.at(1).deadline, 1s);
    EXPECT_EQ(limited.requests.at(1).response,
              3 * limited.requests[1].transaction + limited.requests[0].transaction + 1ms);
    EXPECT_EQ(*limited.requests.at(0).response,
              3 * limited.requests[1].transaction + limited.requests[0].transaction + 1ms);
}

TEST(Guarantee, PolledTriggeredAndWrittenAreTasksOfTheirOwn) {
    auto made = known({int16(0).read(3).read_on(0).write(0x10).on_change()});
    made.locals.push_back({.name = "go", .admission = model::RateLimit{.min_interval = 500ms}});
    made.lines[0].devices[0].variables[0].admission = model::RateLimit{.min_interval = 2s};
    const Plan plan = make_plan(made);
    ASSERT_EQ(plan.lines[0].requests.size(), 1U);
    LinePlan line = plan.lines[0];
    line.requests[0].admission = model::RateLimit{.min_interval = 2s};
    const auto found = guarantee_line(made, line);
    ASSERT_EQ(found.jobs.size(), 3U);
    EXPECT_EQ(found.jobs[0].bound.deadline, 100ms);
    EXPECT_EQ(found.jobs[1].bound.deadline, 500ms);
    EXPECT_EQ(found.jobs[2].bound.deadline, 2s);
    EXPECT_EQ(found.requests[0].response, found.jobs[0].bound.response);
    EXPECT_EQ(*found.jobs[0].bound.response, found.jobs[0].bound.transaction +
                                                 found.jobs[1].bound.transaction +
                                                 found.jobs[2].bound.transaction + 1ms);
}

TEST(Guarantee, ReadModifyWriteIsOneFrameOfBothTransactions) {
    auto made = known({int16(0).write(6).on_change()});
    made.lines[0].devices[0].variables[0].admission = model::RateLimit{.min_interval = 2s};
    LinePlan line = make_plan(made).lines[0];
    line.requests[0].admission = model::RateLimit{.min_interval = 2s};
    const auto written = guarantee_line(made, line).requests[0];
    line.requests[0].read_modify_write = true;
    const auto both = guarantee_line(made, line).requests[0];
    EXPECT_GT(both.transaction, 2 * written.transaction - 1ms);
    EXPECT_EQ(both.response, both.transaction + 1ms);
    EXPECT_GE(both.failure, both.transaction);
}

TEST(Guarantee, WhatIsVerifiedIsReadBackByAFrameOfItsOwn) {
    auto made = known({int16(0).write(0x10).on_change()});
    auto& variable = made.lines[0].devices[0].variables[0];
    LinePlan line = make_plan(made).lines[0];
    line.requests[0].admission = model::RateLimit{.min_interval = 2s};
    const auto written = guarantee_line(made, line).requests[0];
    Request polled = line.requests[0];
    polled.write.reset();
    polled.admission.reset();
    polled.write_on_change = false;
    polled.read = wire::Function::read_holding_registers;
    polled.period = 10s;
    LinePlan reading = line;
    reading.requests = {polled};
    const auto read = guarantee_line(made, reading).requests[0];
    variable.verify = true;
    const auto verified = guarantee_line(made, line).requests[0];
    EXPECT_EQ(verified.transaction, written.transaction + read.transaction);
    EXPECT_EQ(*verified.response, *written.response + read.transaction);
    // The less urgent request delays it by its frame, and waits for both.
    line.requests.push_back(polled);
    const auto beside = guarantee_line(made, line).requests;
    EXPECT_EQ(*beside[0].response, *verified.response + read.transaction);
    EXPECT_EQ(*beside[1].response, verified.transaction + read.transaction + 1ms);
}

// Streams
// -----------------------------------------------------------------------------------------------------

// One register every 100 ms, and beside it one every 300 ms: a request of one at 0 and 100, of two at 200.
LinePlan taking_turns() {
    LinePlan line;
    for (const Duration phase : {0ms, 100ms, 200ms}) {
        Request request{.variables = {0}, .read = wire::Function::read_holding_registers, .quantity = 1};
        if (phase == 200ms) request.variables.push_back(1), request.quantity = 41;
        request.period = 300ms;
        request.phase = phase;
        request.stream = 1;
        request.deadline = 100ms;
        line.requests.push_back(request);
    }
    return line;
}

TEST(Guarantee, RequestsThatTakeTurnsAreOneTask) {
    auto made = known({int16(0).read(3), int16(40).read(3).every(300ms)});
    const LinePlan line = taking_turns();
    const auto found = guarantee_line(made, line);
    const Duration longest = found.requests[2].transaction;
    for (const auto& bound : found.requests) EXPECT_EQ(bound.response, longest + 1ms);
    EXPECT_EQ(found.ages[0][0], 100ms + longest + 1ms);
    EXPECT_EQ(found.ages[0][1], 300ms + longest + 1ms);
    EXPECT_EQ(found.requests[0].age, found.ages[0][0]);
    EXPECT_EQ(found.requests[2].age, found.ages[0][1]);
    const auto sum = 2 * found.requests[0].transaction + longest;
    EXPECT_NEAR(found.utilization, static_cast<double>(sum.count()) / 300e6, 1e-9);
}

TEST(Guarantee, TheOnlyStreamOfAPlanIsOneTaskToo) {
    std::vector<Item> items;
    for (int i = 0; i < 6; ++i) items.push_back(int16(3 * i).read(3).every(i % 2 == 0 ? 200ms : 400ms));
    auto made = known(items, {.strategy = model::Strategy::optimal});
    made.lines[0].devices[0].gaps = model::Gaps::always;
    const Plan plan = make_plan(made);
    const auto& requests = plan.lines[0].requests;
    ASSERT_EQ(requests.size(), 2U);
    ASSERT_EQ(requests[0].stream, requests[1].stream);
    const auto found = guarantee(made, plan).at(0);
    const Duration longest = std::max(found.requests[0].transaction, found.requests[1].transaction);
    EXPECT_EQ(found.requests[0].response, longest + 1ms);
    EXPECT_EQ(found.requests[1].response, longest + 1ms);
    EXPECT_EQ(found.ages[0][0], 200ms + longest + 1ms);
}

TEST(Guarantee, UnconfirmedHolesAreProvedWithAndWithout) {
    std::vector<Item> items;
    for (int i = 0; i < 6; ++i) items.push_back(int16(3 * i).read(3).every(200ms));
    auto made = known(items, {.strategy = model::Strategy::optimal});
    model::Gaps& gaps = made.lines[0].devices[0].gaps;
    gaps = model::Gaps::never;
    const auto sure = guarantee(made, make_plan(made)).at(0);
    gaps = model::Gaps::learn;
    const Plan plan = make_plan(made);
    ASSERT_EQ(plan.lines[0].requests.size(), 1U);
    const auto learnt = guarantee(made, plan).at(0);
    EXPECT_EQ(learnt.requests[0].response, sure.requests.back().response);
    EXPECT_EQ(learnt.ages, sure.ages);
    EXPECT_EQ(learnt.utilization, sure.utilization);
    EXPECT_LT(guarantee_line(made, plan.lines[0]).requests[0].response, learnt.requests[0].response);
}

TEST(Guarantee, ALineDoesNotDependOnOthersThatLearn) {
    auto made = known({item(DataType::string, 0, 200).read(3), int16(300).read(3).every(50ms)},
                      {.strategy = model::Strategy::optimal});
    const auto alone = guarantee(made, make_plan(made)).at(0);
    made.lines.push_back(made.lines[0]);
    made.lines[1].devices[0].gaps = model::Gaps::learn;
    const auto beside = guarantee(made, make_plan(made)).at(0);
    ASSERT_EQ(beside.requests.size(), alone.requests.size());
    for (std::size_t i = 0; i < alone.requests.size(); ++i)
        EXPECT_EQ(beside.requests[i].response, alone.requests[i].response);
    EXPECT_EQ(beside.ages, alone.ages);
}

// Read together while the holes are filled, each on its own when they are not: the slow one is late for the
// fast one's deadline then, and not for its own.
TEST(Guarantee, WithoutItsHolesASlowValueHasItsOwnDeadline) {
    auto made = known({int16(0).read(3).every(50ms), int16(3).read(3).every(400ms),
                       int16(6).read(3).every(400ms), int16(9).read(3).every(400ms)},
                      {.strategy = model::Strategy::optimal});
    made.lines[0].format = {19200, 8, wire::Parity::even, 1};
    made.lines[0].devices[0].gaps = model::Gaps::learn;
    const auto found = guarantee(made, make_plan(made)).at(0);
    EXPECT_TRUE(found.feasible);
    for (const auto& job : found.jobs) EXPECT_FALSE(job.late());
    EXPECT_GT(found.ages[0][3], 400ms + 50ms);
}

TEST(Guarantee, UnevenTurnsMakeAValueAsOldAsTheLongestPause) {
    auto made = known({int16(0).read(3), int16(40).read(3).every(300ms)});
    LinePlan line = taking_turns();
    line.requests.erase(line.requests.begin());
    const auto found = guarantee_line(made, line);
    EXPECT_EQ(found.ages[0][0], 200ms + *found.requests[0].response);
}

TEST(Guarantee, AValueInTwoRequestsIsAsOldAsItsOlderPart) {
    auto made = known({item(DataType::string, 0, 20).read(3).every(200ms)});
    LinePlan line;
    for (const int start : {0, 16})
        line.requests.push_back({.variables = {0},
                                 .read = wire::Function::read_holding_registers,
                                 .start = static_cast<std::uint16_t>(start),
                                 .quantity = static_cast<std::uint16_t>(start == 0 ? 16 : 4),
                                 .period = 200ms,
                                 .stream = 1});
    const auto found = guarantee_line(made, line);
    EXPECT_EQ(found.ages[0][0], 200ms + *found.requests[1].response);
    EXPECT_EQ(found.requests[0].age, found.ages[0][0]);
}

TEST(Guarantee, CoprimePeriodsOfAStreamDoNotExplode) {
    auto made = known({int16(0).read(3).every(65'521ms)});
    LinePlan line;
    for (const Duration period : {65'521ms, 65'519ms, 65'497ms})
        line.requests.push_back({.variables = {0},
                                 .read = wire::Function::read_holding_registers,
                                 .quantity = 1,
                                 .period = period,
                                 .stream = 1,
                                 .deadline = period});
    const auto found = guarantee_line(made, line);
    EXPECT_EQ(found.ages[0][0], 65'497ms + *found.requests[0].response);
}

// Several requests in flight
// ---------------------------------------------------------------------------------

/// Eight devices behind one connection, each with a read of 100 ms.
model::Project connection_of(std::uint16_t in_flight, Duration longest, std::uint16_t measured_with) {
    model::Project project;
    auto& line = project.lines.emplace_back();
    line.transport = model::Transport::tcp;
    line.framing = wire::Framing::tcp;
    line.format.baud = 0;
    for (std::uint8_t unit = 1; unit <= 8; ++unit) {
        auto& device = line.devices.emplace_back();
        device.name = "D" + std::to_string(unit);
        device.address = UnitId{unit};
        device.in_flight = in_flight;
        device.measured_round_trip = model::MeasuredRoundTrip{longest, 1ms, 99'000, measured_with};
        device.variables.push_back(int16(0).read(3).every(100ms).named("V" + std::to_string(unit)));
    }
    return project;
}

LineGuarantee proof_of(const model::Project& project) {
    return guarantee(project, make_plan(project)).at(0);
}

TEST(Guarantee, RequestsInFlightAreNotProvedAsIfOneFollowedTheOther) {
    const auto alone = proof_of(connection_of(1, 20ms, 1));
    EXPECT_FALSE(alone.feasible) << "8 times 20 ms in 100 ms";
    EXPECT_GT(alone.utilization, 1.6);
    const auto four = proof_of(connection_of(4, 20ms, 4));
    EXPECT_TRUE(four.feasible);
    EXPECT_EQ(four.in_flight, 4U);
    EXPECT_NEAR(four.utilization, alone.utilization / 4, 1e-9);
    for (const auto& request : four.requests) {
        EXPECT_GE(request.response, 20ms);
        EXPECT_LE(request.response, 100ms);
    }
}

TEST(Guarantee, ARoundTripMeasuredWithLessInFlightCountsAsServedInOrder) {
    const auto four = proof_of(connection_of(4, 5ms, 1));
    const auto one = proof_of(connection_of(1, 5ms, 1));
    EXPECT_NEAR(four.utilization, one.utilization, 0.02);
    EXPECT_GE(four.requests[0].transaction, 20ms);
    EXPECT_GT(four.requests[0].response, one.requests[0].response) << "more is on its way before it";
}

TEST(Guarantee, StatesWhatTheResponseTimesRestOn) {
    auto project = connection_of(1, 5ms, 1);
    EXPECT_EQ(response_source(project.lines[0]), ResponseSource::measured);
    for (auto& device : project.lines[0].devices) device.turnaround = 5ms;
    EXPECT_EQ(response_source(project.lines[0]), ResponseSource::written);
    project.lines[0].devices[3].turnaround.reset();
    EXPECT_EQ(response_source(project.lines[0]), ResponseSource::measured);
    project.lines[0].devices[3].measured_round_trip.reset();
    EXPECT_EQ(response_source(project.lines[0]), ResponseSource::time_out);
    EXPECT_EQ(name(ResponseSource::time_out), "time_out");
}

TEST(Guarantee, DevicesThatTakeLessShareTheConnection) {
    auto project = connection_of(4, 10ms, 4);
    const auto all = proof_of(project);
    for (std::size_t i = 1; i < 8; ++i) project.lines[0].devices[i].in_flight = 1;
    const auto limited = proof_of(project);
    EXPECT_TRUE(limited.feasible);
    EXPECT_GE(limited.requests[7].response, all.requests[7].response);
}

}  // namespace guarantee_test
}  // namespace takt::plan
